// The page of `multilayer explore` for a model beside its measurements. It holds the coordinates of all unknowns, standard
// normal ones of their priors, and its history; the server computes and fits. Texts become text nodes, never markup.
"use strict";

const REACH = 3, STEPS = 400;
const KEPT = "multilayer " + location.pathname;
const state = {z: null, effects: {}, held: [], at: 0, gap: false, beside: null, past: [], future: [], edit: ""};
let start = null, result = null, problems = [], said = [], busy = "", begun = 0, cursor = null, fitted = false;
const rows = new Map(); // by the name of an unknown: functions that show its value again

const design = () => ({z: state.z, effects: state.effects});
function names() { // of all unknowns, in the order of their coordinates
  const chosen = Object.keys(state.effects).flatMap(name => start.effects.find(one => one.name === name).unknowns);
  return [...start.unknowns, ...chosen].map(one => one.name);
}
function coordinate(name, from = state) {
  const i = start.unknowns.findIndex(one => one.name === name);
  if (i >= 0) return from.z[i];
  const effect = start.effects.find(one => one.unknowns.some(inner => inner.name === name));
  return from.effects[effect.name]?.[effect.unknowns.findIndex(one => one.name === name)];
}
function withCoordinate(name, value) {
  const next = copied(design()), i = start.unknowns.findIndex(one => one.name === name);
  if (i >= 0) { next.z[i] = value; return next; }
  const effect = start.effects.find(one => one.unknowns.some(inner => inner.name === name));
  next.effects[effect.name][effect.unknowns.findIndex(one => one.name === name)] = value;
  return next;
}

// -- history --------------------------------------------------------------------------------------------------------

function change(next, edit = "") {
  const text = JSON.stringify(next);
  if (text === JSON.stringify(design())) return false;
  remember(state, JSON.stringify(design()), edit);
  Object.assign(state, next);
  showHistory();
  return true;
}
function step(from, to, what) {
  if (!from.length) return;
  to.push(JSON.stringify(design()));
  Object.assign(state, JSON.parse(from.pop()), {edit: ""});
  showHistory();
  showEffects();
  evaluate();
  say(what);
}
const undo = () => step(state.past, state.future, "undone");
const redo = () => step(state.future, state.past, "done again");
function showHistory() {
  $("undo").disabled = Boolean(busy) || !state.past.length;
  $("redo").disabled = Boolean(busy) || !state.future.length;
  try {
    sessionStorage.setItem(KEPT, JSON.stringify({...state, past: state.past.slice(-50)}));
  } catch { /* a full or forbidden storage: a reload then begins with the nominal model */ }
}

// -- asking: one question at a time, the latest state next ----------------------------------------------------------

let asking = false, again = null;
const typed = []; // values that were typed, each asked before anything else
function evaluate(more = {}) {
  again = {question: "evaluate", ...again, ...more};
  return asking || (asking = answerAll().finally(() => { asking = false; }));
}
async function answerAll() {
  while (again || typed.length) {
    const value = typed.shift(), {question, ...more} = value ? {question: "evaluate", typed: value} : again;
    const from = begun, beside = state.beside || {z: start.z, effects: {}};
    if (!value) again = null;
    begun = 0;
    const sent = JSON.stringify(design());
    const answer = await ask(question, {...design(), at: state.at, beside, ...more});
    if (!answer) return;
    problems = answer.problems;
    fitted = false;
    if (!problems.length) {
      result = answer;
      if (value && coordinate(value.name) !== undefined) change(withCoordinate(value.name, coordinate(value.name, answer)));
      if (question === "fit" && sent === JSON.stringify(design())) { change({z: answer.z, effects: answer.effects}); fitted = true; }
    } else if (value && again) { typed.length = 0; again = null; } // what came after would hide why it was refused
    said = answer.warnings || [];
    document.body.classList.toggle("stale", problems.length > 0);
    show();
    if (from) {
      const latency = performance.now() - from;
      document.body.dataset.latency = latency.toFixed(1);
      $("latency").textContent = ` Curves ${Math.round(latency)} ms after the slider.`;
    }
  }
}
function waiting(text) { // for what takes longer than a slider may
  busy = text;
  document.body.classList.toggle("busy", Boolean(text));
  for (const id of ["fit", "nominal"]) $(id).disabled = Boolean(text);
  showHistory();
  if (text) say(text);
}
async function fit() {
  if (busy) return;
  const before = result?.misfit;
  waiting("fitting");
  state.edit = "";
  try {
    await evaluate({question: "fit", held: state.held});
  } finally {
    waiting("");
  }
  if (fitted) say(`fitted; misfit ${short(before)} before, ${short(result.misfit)} now`);
}
function nominal() {
  if (!change({z: copied(start.z), effects: {}})) return;
  showEffects();
  evaluate();
  say("the nominal model");
}
function freeze() {
  state.beside = copied(design());
  showHistory();
  evaluate();
  say("the curves beside are those of the model as it is now");
}

// -- unknowns -------------------------------------------------------------------------------------------------------

function row(one) {
  const id = "at-" + one.name.replace(/[^\p{L}\p{N}_]+/gu, "-");
  let reach = REACH, dirty = false; // a text that was not asked yet stays
  const slider = make("input", {type: "range", min: -STEPS, max: STEPS, step: 1, id: id + "-slider", "aria-label": one.title});
  const box = make("input", {type: "text", id, spellcheck: "false", autocomplete: "off"});
  const unit = make("span", {class: "unit"}), told = make("span", {class: "meaning"});
  const held = make("input", {type: "checkbox", id: id + "-held", "aria-label": `hold ${one.title}`, title: "hold it when the rest is fitted"});
  held.checked = state.held.includes(one.name);
  function place(z) {
    if (Math.abs(z) > reach) reach = 1.5 * Math.abs(z);
    slider.value = Math.round(STEPS * z / reach);
  }
  function update(value, z) {
    if (!dirty) box.value = value.text;
    unit.textContent = value.unit;
    slider.setAttribute("aria-valuetext", `${value.text} ${value.unit}`);
    place(z);
    told.textContent = one.stated ? `${short(z, 2)} stated standard deviations off` : Math.abs(z) > REACH ? "beyond what is usual" : "";
  }
  slider.addEventListener("input", () => {
    if (busy || !change(withCoordinate(one.name, reach * slider.value / STEPS), id)) return;
    begun = begun || performance.now();
    evaluate();
  });
  oneStepEach(slider, id);
  box.addEventListener("input", () => { dirty = true; });
  box.addEventListener("change", () => { dirty = false; state.edit = ""; typed.push({name: one.name, text: box.value.trim()}); evaluate(); });
  box.addEventListener("keydown", event => { if (event.key === "Enter") { event.stopPropagation(); box.blur(); box.focus(); } });
  held.addEventListener("change", () => {
    state.held = state.held.filter(name => name !== one.name);
    if (held.checked) state.held.push(one.name);
    showHistory();
  });
  rows.set(one.name, update);
  return make("div", {class: "setting"},
    make("div", {class: "head turned"}, make("label", {for: id}, one.title), box, unit, make("label", {class: "held", title: held.title}, held, " hold")),
    slider, told);
}
function showEffects() {
  const focused = document.activeElement?.id;
  for (const effect of start.effects) effect.unknowns.forEach(one => rows.delete(one.name));
  $("effects").replaceChildren(...start.effects.map(effect => {
    const box = make("input", {type: "checkbox", id: `effect-${effect.name}`}), chosen = effect.name in state.effects;
    box.checked = chosen;
    box.addEventListener("change", async () => {
      if (busy) { box.checked = !box.checked; return; }
      const next = copied(design());
      if (box.checked) next.effects[effect.name] = copied(effect.z); else delete next.effects[effect.name];
      change(next);
      showEffects();
      if (box.checked && effect.slow) waiting("making finite elements, once");
      await evaluate();
      if (busy) { waiting(""); say("ready"); }
    });
    return make("li", {class: chosen ? "card chosen" : "card"},
      make("label", {title: `${effect.summary} ${effect.law}`}, box, ` ${effect.title}`, chosen ? make("span", {class: "meaning"}, effect.summary) : null),
      chosen ? make("div", {class: "body"}, ...effect.unknowns.map(row)) : null);
  }));
  if (result && !problems.length) showValues();
  if (focused) document.getElementById(focused)?.focus({preventScroll: true});
}
function showValues() {
  for (const name of names()) {
    const value = result.values[name], update = rows.get(name);
    if (value && update) update(value, coordinate(name));
  }
}

// -- curves ---------------------------------------------------------------------------------------------------------

function show() {
  showBanners();
  if (!result) return;
  showValues();
  showRatings();
  showLegend();
  showCharts();
}
function showBanners() {
  const told = [];
  if (ended) told.push(make("div", {class: "banner"}, make("p", {}, "multilayer explore has ended, so nothing is computed here.")));
  if (problems.length) told.push(make("div", {class: "banner"}, make("p", {}, "Not computed; the curves are those from before."), ...problems.map(one => make("p", {}, one.text))));
  if (said.length) told.push(make("div", {class: "banner remark"}, ...said.slice(0, 6).map(text => make("p", {}, text))));
  $("banners").replaceChildren(...told);
}
function chance(p) { return p < 1e-6 ? "below 1e-6" : short(p, 2); }
function showRatings() {
  const one = (title, value, more) => make("div", {}, make("dt", {}, title), make("dd", {}, value, make("span", {class: "before"}, ` ${more}`)));
  const several = result.misfits.length > 1;
  $("ratings").replaceChildren(
    one("misfit per datum", short(result.misfit), `probability ${chance(result.p_value)}`),
    ...(several ? [one("of this configuration", short(result.misfits[state.at]), "1 is noise")] : []),
    ...(start.unknowns.some(inner => inner.stated) ? [one("stated quantities", chance(result.stated_p_value), "probability of what they are here")] : []));
  const list = $("configuration");
  [...list.options].forEach((option, i) => { option.textContent = `${start.configurations[i]} (misfit ${short(result.misfits[i], 2)})`; });
}
function showLegend() {
  const beside = state.beside ? "the model you chose to compare with" : "nominal model";
  $("curves").replaceChildren(
    state.gap ? make("li", {}, make("span", {class: "bar"}), "noise and error of the model") : make("li", {}, make("span", {class: "swatch dots m"}), "measured"),
    make("li", {}, make("span", {class: state.gap ? "swatch dots now" : "swatch now"}), "model"),
    make("li", {}, make("span", {class: state.gap ? "swatch dots c0" : "swatch c0"}), beside,
      state.beside ? make("button", {type: "button", class: "small", id: "unfreeze", "aria-label": "compare with the nominal model again",
        onclick: () => { state.beside = null; showHistory(); evaluate(); $("freeze").focus(); }}, "×") : null));
}
// the curves of a part: of each, a value for every frequency
function lines(k) {
  const part = result.curves.parts[k], less = one => one && one.map((v, i) => v === null || part.measured[i] === null ? null : part.measured[i] - v);
  if (!state.gap) return {dots: part.measured, now: part.model, c0: part.beside};
  return {dots: less(part.model), c0dots: less(part.beside)};
}
function limits(all) {
  const values = all.filter(Boolean).flat().filter(v => v !== null);
  if (!values.length) return [0, 1];
  let low = Math.min(...values), high = Math.max(...values);
  if (!(high > low)) { low -= 1; high += 1; }
  return toTicks(low, high);
}
function runs(frequency, burst, values, turn) { // a curve is drawn burst by burst where they lie apart, and not across a turn
  const found = [];
  frequency.forEach((f, i) => {
    if (values[i] === null) return;
    const last = found[found.length - 1], [at, value] = last ? last.points[last.points.length - 1] : [];
    if (last && last.burst === burst[i] && f > at && Math.abs(values[i] - value) < turn / 2) last.points.push([f, values[i]]);
    else found.push({burst: burst[i], points: [[f, values[i]]]});
  });
  return found.map(one => one.points);
}
function showCharts() {
  const box = $("charts");
  while (box.children.length > start.parts.length) box.lastChild.remove();
  while (box.children.length < start.parts.length) box.append(make("div", {class: "chart"}, make("h3"), make("div")));
  start.parts.forEach((part, k) => {
    const title = state.gap ? `${part.title}: measured − modelled` : part.title;
    box.children[k].firstChild.replaceChildren(make("span", {}, title + (part.unit ? ` / ${part.unit}` : "")), make("span", {class: "read"}));
    const holder = box.children[k].lastChild;
    holder.replaceChildren(chart(k, title, holder.clientWidth));
  });
  showReading();
}
function ends() {
  const all = result.curves.frequency, low = Math.min(...all), high = Math.max(...all);
  return [low, high];
}
function chart(k, title, wide) {
  const width = Math.max(240, wide), at = axes(width, ...ends()), {frequency, burst} = result.curves, shown = lines(k);
  const spread = result.curves.parts[k].spread, bars = state.gap ? spread.flatMap(s => [s, -s]) : null;
  const {svg, inside, y} = frame(`part-${k}`, title, width, at, limits([...Object.values(shown), bars]), share => {
    cursor = at.frequency(share);
    $("read-at").value = STEPS * share;
    showReading();
  });
  const turn = start.parts[k].unit === "degrees" ? 360 : Infinity, together = burst.map(() => 0);
  const pieces = values => runs(frequency, start.apart ? burst : together, values, turn);
  frequency.forEach((f, i) => {
    const v = shown.dots[i], s = spread[i];
    if (v === null || s === null) return;
    const middle = state.gap ? 0 : v; // of a gap, the noise stands about 0
    inside.append(draw("path", {class: "spread", d: `M${at.x(f).toFixed(1)} ${y(middle - s).toFixed(1)} V${y(middle + s).toFixed(1)}`}));
  });
  const dots = (values, name) => values.forEach((v, i) => { if (v !== null) inside.append(draw("circle", {cx: at.x(frequency[i]), cy: y(v), r: 2.2, class: `point ${name}`})); });
  if (shown.c0dots) dots(shown.c0dots, "c0");
  dots(shown.dots, state.gap ? "now" : "m");
  for (const name of ["c0", "now"]) if (shown[name]) for (const points of pieces(shown[name])) inside.append(draw("path", {d: line(points, at, y), class: `curve ${name}`}));
  return svg;
}
function showReading() {
  const all = result.curves.frequency, [low, high] = ends(), share = $("read-at").value / STEPS;
  if (cursor === null || cursor < low || cursor > high) cursor = axes(0, low, high).frequency(share);
  const i = nearest(all, cursor), f = all[i];
  $("read-frequency").textContent = hertz(f);
  $("read-at").setAttribute("aria-valuetext", hertz(f));
  start.parts.forEach((part, k) => {
    const box = $("charts").children[k], svg = box.querySelector("svg"), at = axes(svg.viewBox.baseVal.width, low, high), one = result.curves.parts[k];
    svg.querySelector(".cursor").setAttribute("d", `M${at.x(f)} ${at.top} V${at.bottom}`);
    const words = [["m", `measured ${short(one.measured[i])} ± ${short(one.spread[i], 2)}`], ["now", `model ${short(one.model[i])}`]];
    if (one.beside) words.push(["c0", short(one.beside[i])]);
    box.querySelector(".read").replaceChildren(`${hertz(f)}: `, ...words.flatMap(([name, text], j) => [j ? ", " : "", make("span", {class: name}, text)]));
  });
}

// -- beginning ------------------------------------------------------------------------------------------------------

function listen() {
  $("undo").addEventListener("click", undo);
  $("redo").addEventListener("click", redo);
  $("fit").addEventListener("click", fit);
  $("nominal").addEventListener("click", nominal);
  $("freeze").addEventListener("click", freeze);
  $("gap").addEventListener("change", () => { state.gap = $("gap").checked; showHistory(); if (result) show(); });
  $("configuration").addEventListener("change", () => { state.at = Number($("configuration").value); showHistory(); evaluate(); });
  $("read-at").addEventListener("input", () => { cursor = null; showReading(); });
  document.addEventListener("keydown", event => {
    const typing = event.target.matches?.("input[type=text], select, button, summary"), key = event.key.toLowerCase(), control = event.ctrlKey || event.metaKey;
    if (control && key === "z" && !event.target.matches?.("input[type=text]")) { event.preventDefault(); if (!busy) (event.shiftKey ? redo : undo)(); }
    else if (control && key === "y") { event.preventDefault(); if (!busy) redo(); }
    else if (control || event.altKey || typing) return;
    else if (key === "f") freeze();
    else if (key === "enter") fit();
  });
  onResize(() => { if (result) showCharts(); });
}
async function begin() {
  start = await ask("start");
  if (!start) return;
  if (!start.z) { problems = start.problems; showBanners(); return; }
  $("file").textContent = start.file;
  document.title = `${start.file}: multilayer explore`;
  Object.assign(state, copied(start.first || {z: start.z, effects: {}})); // a diagnosis begins with what it named
  try {
    const kept = JSON.parse(sessionStorage.getItem(KEPT));
    if (kept?.z?.length === start.z.length) Object.assign(state, kept);
  } catch { /* nothing was kept */ }
  $("gap").checked = state.gap;
  $("which").hidden = start.configurations.length < 2;
  $("configuration").replaceChildren(...start.configurations.map((name, i) => make("option", {value: i}, name)));
  $("configuration").value = state.at;
  const stated = start.unknowns.filter(one => one.stated);
  $("unknowns").replaceChildren(...start.unknowns.filter(one => !one.stated).map(row));
  $("stated").replaceChildren(...stated.map(row));
  $("stated-box").hidden = !stated.length;
  listen();
  showHistory();
  showEffects();
  await evaluate();
  document.body.dataset.ready = "yes";
}
begin();
