// The page of `multilayer explore`. It holds the design (the data of a stack or simulation file), its history and its
// frozen curves; the server computes, validates and saves. Texts become text nodes and attributes, never markup.
"use strict";

// steps of a slider: 1.2 % each over two decades, so that no two of them are the same to three digits
const STEPS = 400, MOST_FROZEN = 4, MOST_POINTS = 400, SETTLED = 180, WATCHED = 2000;
const WISHED = 60, LEAST_POINTS = 40; // ms that curves may take while a slider moves; fewer frequencies gain nothing
const KEPT = "multilayer " + location.pathname;

const state = {
  data: null, digest: "", saved: "", file: "", past: [], future: [], edit: "", frozen: [], hidden: ["reflection", "transmission"],
  open: 0, // the layer looked at
};
let start = null, described = null, result = null, problems = [], cost = 0.1, changedTo = "", said = [];
const updaters = new Map(); // by place: functions that show a field's description again

// -- small things ---------------------------------------------------------------------------------------------------

const placeId = path => "at-" + path.join("-");
function getAt(data, path) {
  return path.reduce((inner, key) => (inner === undefined || inner === null ? undefined : inner[key]), data);
}
function setAt(data, path, value, wholes = []) {
  const [key, ...rest] = path;
  if (!rest.length) {
    if (value === undefined) delete data[key]; else data[key] = value;
    return;
  }
  if (data[key] === undefined || data[key] === null || typeof data[key] !== "object") data[key] = wholes[0] ? copied(wholes[0]) : {};
  setAt(data[key], rest, value, wholes.slice(1));
}

// -- the design and its history -------------------------------------------------------------------------------------

// One step of the history for each edit; a slider that is dragged, or moved by keys, is one edit as long as `edit` stays.
function change(data, edit = "") {
  const text = JSON.stringify(data);
  if (text === JSON.stringify(state.data)) return false;
  remember(state, JSON.stringify(state.data), edit);
  said = [];
  state.data = data;
  showHistory();
  return true;
}
function step(from, to, what) {
  if (!from.length) return;
  to.push(JSON.stringify(state.data));
  state.data = JSON.parse(from.pop());
  said = [];
  showHistory();
  renew();
  say(what);
}
const undo = () => step(state.past, state.future, "undone");
const redo = () => step(state.future, state.past, "done again");
function showHistory() {
  $("undo").disabled = !state.past.length;
  $("redo").disabled = !state.future.length;
  $("unsaved").hidden = !isUnsaved();
  keep();
}
const isUnsaved = () => JSON.stringify(state.data) !== state.saved;
function keep() { // so that a reload of the window loses nothing; of this window alone
  try {
    sessionStorage.setItem(KEPT, JSON.stringify({...state, past: state.past.slice(-50)}));
  } catch { /* a full or forbidden storage: a reload then begins again with the file */ }
}

// Controls stand for the layers of the design that they were made for: they wait until those of another one are there, and
// while an edit is asked for.
let renewed = 0, made = 0, editing = false, keyboardAt = null;
const isWaiting = () => editing || made !== renewed;
function showWaiting() {
  const controls = $("controls"), here = document.activeElement, waits = isWaiting();
  if (waits === controls.inert) return;
  controls.inert = waits;
  if (waits) keyboardAt = controls.contains(here) ? here : null;
  else if (keyboardAt && here === document.body) (keyboardAt.isConnected ? keyboardAt : document.getElementById(keyboardAt.id))?.focus({preventScroll: true});
}
function renew() { // after the design has become another one
  renewed += 1;
  showWaiting();
  return refresh(true);
}
async function edited(what) { // the answer to an edit of the design as it is; null without one
  const before = renewed;
  let sent = null, answer = null;
  do { // again where something was moved meanwhile
    sent = state.data;
    answer = await ask("edit", {data: sent, edit: what});
  } while (answer && sent !== state.data && before === renewed);
  if (before === renewed) return answer;
  say("the design has become another one meanwhile, so this was not done");
  return null;
}
async function edit(what, message) {
  if (isWaiting()) return;
  editing = true;
  setTimeout(showWaiting); // a box that is left is followed by where the keyboard goes
  const answer = await edited(what);
  editing = false;
  showWaiting();
  if (!answer || answer.problems.length) {
    if (answer) said = answer.problems.map(one => one.text);
    showBanners();
    drawnOutline = ""; // lists show again what there is
    refresh();
    return;
  }
  state.open = answer.layer;
  change(answer.data);
  said = answer.notices;
  await renew();
  say(message);
  const summary = document.querySelector(`#layers > li:nth-child(${answer.layer + 1}) summary`);
  if (summary && !document.activeElement.closest("#layers > li")) summary.focus({preventScroll: true});
}

// -- asking for curves: one question at a time, the latest state next -----------------------------------------------

let asking = false, again = null, settling = 0, begun = 0, rested = null; // the design last computed at rest
function follow() { // while something moves
  begun = begun || performance.now();
  const points = Math.max(LEAST_POINTS, Math.min(MOST_POINTS, Math.floor(WISHED / cost)));
  request({points: points < MOST_POINTS ? points : undefined, describe: false, moving: true});
  clearTimeout(settling);
  settling = setTimeout(() => refresh(), SETTLED);
}
function refresh(rebuild = false) { // all frequencies, and what the controls show
  clearTimeout(settling);
  if (rebuild) state.edit = "";
  return request({describe: true});
}
function request(options) {
  again = {...options, describe: options.describe || (again !== null && again.describe)};
  if (again.describe) { again.points = undefined; again.moving = false; }
  return asking || (asking = answerAll().finally(() => { asking = false; }));
}
async function answerAll() {
  while (again) {
    const options = again;
    again = null;
    const from = begun;
    begun = 0;
    const data = state.data, asked = renewed;
    const answer = await ask("evaluate", {data, ...options});
    if (!answer) continue;
    if (options.describe) rested = data;
    if (options.describe && asked === renewed) { // else these are layers of a design that is no more
      made = asked;
      if (answer.layers) { // else the design cannot be described, and what there was may be turned back
        described = answer;
        showControls();
      }
      showWaiting();
    }
    shown({...answer, data}, from);
  }
}
function shown(answer, from) {
  problems = answer.problems;
  if (!problems.length) {
    // while a slider moves fewer frequencies may be drawn, too few for ratings; what is told of validity comes at rest
    const pending = !answer.layers && result && answer.left_out > result.all_left_out;
    if (!answer.layers && result) answer.warnings = result.warnings;
    if (pending) answer.ratings = result.ratings;
    answer.all_left_out = answer.layers || !result ? answer.left_out : result.all_left_out;
    $("ratings").classList.toggle("pending", Boolean(pending));
    result = answer;
    if (answer.layers) cost = Math.max(answer.elapsed / answer.frequency.length, 0.01); // of all frequencies
  }
  document.body.classList.toggle("stale", problems.length > 0);
  showProblems();
  showResult();
  if (from) {
    const latency = performance.now() - from;
    document.body.dataset.latency = latency.toFixed(1);
    $("latency").textContent = ` Curves ${Math.round(latency)} ms after the slider.`;
  }
}

// -- problems -------------------------------------------------------------------------------------------------------

function showProblems() {
  document.querySelectorAll("[aria-invalid]").forEach(one => one.removeAttribute("aria-invalid"));
  document.querySelectorAll(".wrong").forEach(one => { one.textContent = ""; one.hidden = true; });
  for (const problem of problems) {
    const field = document.getElementById("at-" + problem.path.split(".").join("-"));
    const told = field && document.getElementById(field.id + "-wrong");
    problem.at = field ? field.id : "";
    if (!told) continue;
    field.setAttribute("aria-invalid", "true");
    told.textContent = problem.text;
    told.hidden = false;
  }
  showBanners();
}
function banner(text, ...more) { return make("div", {class: more.length || problems.length ? "banner" : "banner remark"}, ...text.map(line => make("p", {}, line)), ...more); }
function showBanners() {
  const shown = [];
  if (ended) {
    const text = make("textarea", {readonly: true, "aria-label": "what is on this page", rows: 6}, JSON.stringify(state.data, null, 1));
    shown.push(banner(["multilayer explore has ended, so nothing is computed or saved here. What stands on this page, to be kept as a stack file (JSON is YAML, too):"], text));
  }
  if (changedTo) {
    shown.push(banner(
      [`${start.file} has ${changedTo === "gone" ? "gone from" : "changed on"} the disk since this window read it.`],
      make("div", {class: "actions"},
        changedTo === "gone" ? null : make("button", {type: "button", onclick: readAgain}, "Read it again"),
        make("button", {type: "button", onclick: () => { state.ignored = changedTo; changedTo = ""; keep(); showBanners(); }}, "Go on with what is here"))));
  }
  if (problems.length) {
    const lines = problems.map(one => (one.path ? `${one.path}: ` : "") + one.text);
    shown.push(banner(["Not computed; the curves are those from before.", ...lines]));
  }
  const notes = [...said, ...((problems.length ? [] : result?.warnings) || [])];
  if (notes.length) shown.push(banner(notes.slice(0, 6)));
  const text = shown.map(one => one.textContent).join("\n");
  if ($("banners").dataset.text !== text) { $("banners").replaceChildren(...shown); $("banners").dataset.text = text; }
}

// -- fields ---------------------------------------------------------------------------------------------------------

const inUnit = (field, value) => value / field.factor - field.offset;
function typed(field, number) { // as a file has it
  const digits = Number(number.toPrecision(4));
  return field.symbol ? `${String(digits)} ${field.symbol}` : digits;
}
const bare = /^\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*$/i;
function written(field, text) { // what somebody typed: a bare number is in the unit beside it
  if (text.trim() === "") return undefined;
  if (!bare.test(text)) return text.trim();
  return field.symbol ? `${text.trim()} ${field.symbol}` : Number(text);
}
function toSlider(range, value) {
  const {low, high, scale} = range;
  const share = scale === "log" ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(STEPS * Math.min(1, Math.max(0, share)));
}
function fromSlider(range, position) {
  const {low, high, scale} = range, share = position / STEPS;
  return scale === "log" ? low * (high / low) ** share : low + share * (high - low);
}

function quantity(field, wholes) {
  const id = placeId(field.path);
  let now = field, range = {low: field.low, high: field.high, scale: field.scale};
  const slider = make("input", {type: "range", min: 0, max: STEPS, step: 1, id: id + "-slider", "aria-label": field.title});
  const box = make("input", {type: "text", id, spellcheck: "false", autocomplete: "off", inputmode: "text"});
  const unit = make("span", {class: "unit"}), low = make("span"), high = make("span");
  const clear = make("button", {type: "button", class: "small", "aria-label": `take ${field.title} out`}, "×");
  const note = make("span", {class: "meaning"});
  const root = make("div", {class: "setting"},
    make("div", {class: "head"}, make("label", {for: id}, field.title), box, unit, clear),
    make("div", {class: "ends"}, low, slider, high), note,
    make("p", {class: "wrong", id: id + "-wrong", hidden: true}));
  function shownText(value) { return value === null ? "" : short(inUnit(now, value), 5); }
  function showRange() {
    low.textContent = `${short(inUnit(now, range.low))} ${now.unit}`;
    high.textContent = `${short(inUnit(now, range.high))} ${now.unit}`;
  }
  function place(value) {
    slider.value = toSlider(range, value === null ? now.start : value);
    slider.setAttribute("aria-valuetext", value === null ? "not given" : `${shownText(value)} ${now.unit}`);
  }
  function update(next) {
    const kept = next.value !== null && next.value > range.low && next.value < range.high && next.unit === now.unit;
    now = next;
    if (!kept) range = {low: next.low, high: next.high, scale: next.scale};
    root.classList.toggle("unset", next.value === null);
    unit.textContent = next.unit;
    clear.hidden = !(next.given && !next.borrowed && (!next.required || next.offered));
    clear.title = next.offered ? "back to the value of the material" : "leave it out";
    const given = next.value === null ? (next.required ? "missing" : "not given") : next.borrowed ? "from the material" : "";
    note.replaceChildren([next.meaning, next.allowed].filter(Boolean).join("; "), given ? make("em", {}, `${next.meaning || next.allowed ? "; " : ""}${given}`) : "");
    if (document.activeElement !== box) box.value = shownText(next.value);
    showRange();
    if (document.activeElement !== slider || !kept) place(next.value);
  }
  function set(value, edit) {
    const data = copied(state.data);
    setAt(data, field.path, value, wholes);
    return change(data, edit);
  }
  slider.addEventListener("input", () => {
    const value = fromSlider(range, Number(slider.value)), number = inUnit(now, value);
    const step = Number(number.toPrecision(3));
    if (set(typed(now, step), id)) {
      box.value = short(step, 5);
      slider.setAttribute("aria-valuetext", `${box.value} ${now.unit}`);
      if (field.name === "thickness") { sized(field.path, (step + now.offset) * now.factor); }
      root.classList.remove("unset");
      follow();
    }
  });
  oneStepEach(slider, id);
  box.addEventListener("change", () => { if (set(written(now, box.value))) refresh(); });
  box.addEventListener("keydown", event => { if (event.key === "Enter") box.blur(), box.focus(); });
  clear.addEventListener("click", () => { if (set(undefined)) refresh(true); });
  update(field);
  updaters.set(id, update);
  return root;
}
function sized(path, thickness) { // the drawing follows without waiting
  const layer = described && described.layers[path[1]];
  if (layer && path.length === 3 && path[0] === "layers") { layer.thickness = thickness; showDrawing(); showSummaries(); }
}

function choice(field) {
  const id = placeId(field.path);
  const select = make("select", {id}, ...field.choices.map(one => make("option", {value: one}, one)));
  select.value = field.value ?? "";
  select.addEventListener("change", () => {
    if (field.path[0] === "layers" && field.path.length === 3) {
      edit({do: "become", layer: field.path[1], field: field.name, value: select.value}, `${field.title}: ${select.value}`);
      return;
    }
    const data = copied(state.data);
    setAt(data, field.path, select.value);
    if (change(data)) refresh(true);
  });
  updaters.set(id, next => { select.value = next.value ?? ""; });
  return make("div", {class: "setting"}, make("div", {class: "pair"}, make("label", {for: id}, field.title), select),
    field.meaning ? make("span", {class: "meaning"}, field.meaning) : null, make("p", {class: "wrong", id: id + "-wrong", hidden: true}));
}

function text(field, wholes) {
  const id = placeId(field.path);
  const box = make("input", {type: "text", id, class: "wide", spellcheck: "false", autocomplete: "off", readonly: !field.plain});
  box.value = field.value;
  box.addEventListener("change", () => {
    const data = copied(state.data);
    setAt(data, field.path, box.value.trim() === "" ? undefined : bare.test(box.value) ? Number(box.value) : box.value.trim(), wholes);
    if (change(data)) refresh(true);
  });
  updaters.set(id, next => { if (document.activeElement !== box) box.value = next.value; });
  return make("div", {class: "setting"},
    make("div", {class: "head"}, make("label", {for: id}, field.title), box, make("span", {class: "unit"}, field.unit || "")),
    make("span", {class: "meaning"}, field.plain ? field.meaning : "as it is written in the file; not changed here"),
    make("p", {class: "wrong", id: id + "-wrong", hidden: true}));
}

function control(field, wholes = []) {
  if (field.kind === "quantity") return quantity(field, wholes);
  if (field.kind === "choice") return choice(field);
  if (field.kind === "text") return text(field, wholes);
  const inner = [...wholes];
  inner[field.path.length - 1] = field.whole;
  return make("div", {class: "nested", id: placeId(field.path)},
    make("div", {}, field.title, make("span", {class: "note"}, ` ${field.value.replaceAll("_", " ")}`)),
    ...field.fields.map(one => control(one, inner)), make("p", {class: "wrong", id: placeId(field.path) + "-wrong", hidden: true}));
}

// -- layers ---------------------------------------------------------------------------------------------------------

const outline = fields => fields.map(one => [one.path.join("."), one.kind, one.unit, one.choices, one.fields ? outline(one.fields) : 0]);
let drawnOutline = "";
function showControls() {
  state.open = Math.min(state.open, described.layers.length - 1);
  const now = JSON.stringify([
    described.layers.map(one => [one.type, one.name, one.title, one.material, one.contact, outline(one.fields)]),
    outline(described.ambient), outline(described.behind), state.data.frequency ?? 0, state.data.termination ?? 0,
    incidence(),
  ]);
  if (now !== drawnOutline) rebuild(now); else update();
  showSummaries();
}
function update() {
  const all = fields => fields.forEach(one => { updaters.get(placeId(one.path))?.(one); if (one.fields) all(one.fields); });
  described.layers.forEach(layer => all(layer.fields));
  all(described.ambient);
  all(described.behind);
  showField();
}
function rebuild(now) {
  drawnOutline = now;
  const focused = document.activeElement?.id;
  updaters.clear();
  $("layers").replaceChildren(...described.layers.map(card));
  $("ambient").replaceChildren(...described.ambient.map(one => control(one)));
  $("behind").replaceChildren(...(described.behind.length ? [make("h3", {}, "Fluid behind"), ...described.behind.map(one => control(one))] : []));
  const places = described.layers.map((layer, i) => make("option", {value: i}, `before ${i}, ${layer.title}`));
  $("where").replaceChildren(...places, make("option", {value: described.layers.length, selected: true}, "at the back"));
  showFrequencies();
  showSize();
  showField();
  if (focused) document.getElementById(focused)?.focus({preventScroll: true});
}
function card(layer, i) {
  const last = described.layers.length - 1, prefix = `layer-${i}`;
  const act = (label, name, what, message, disabled = false) =>
    make("button", {type: "button", class: "small", id: `${prefix}-${name}`, disabled, onclick: () => edit(what, message)}, label);
  const name = make("input", {type: "text", id: `at-layers-${i}-name`, spellcheck: "false", autocomplete: "off", placeholder: "no name"});
  name.value = layer.name;
  name.addEventListener("change", () => edit({do: "rename", layer: i, name: name.value}, "renamed"));
  const material = materialSelect(`at-layers-${i}-material`, layer.material);
  material.addEventListener("change", () => edit({do: "become", layer: i, field: "material", value: material.value}, `material: ${material.value || "none"}`));
  const type = make("select", {id: `at-layers-${i}-type`}, ...start.types.map(one => make("option", {value: one.name, title: one.summary}, one.name.replaceAll("_", " "))));
  type.value = layer.type;
  type.addEventListener("change", () => edit({do: "become", layer: i, field: "type", value: type.value}, `type: ${type.value}`));
  const contact = make("select", {id: `${prefix}-contact`}, ...["bonded", "slip"].map(one => make("option", {value: one}, one)));
  contact.value = layer.contact;
  contact.addEventListener("change", () => edit({do: "contact", layer: i, kind: contact.value}, `contact: ${contact.value}`));
  const pair = (label, input) => make("div", {class: "pair"}, make("label", {for: input.id}, label), input);
  const details = make("details", {open: i === state.open, id: prefix},
    make("summary", {},
      make("span", {class: "badge-text"}, String(i)), make("span", {class: "title"}, layer.title),
      make("span", {class: "thick"}), make("span", {class: "what"}, layer.summary)),
    make("div", {class: "body"},
      make("div", {class: "actions", role: "toolbar", "aria-label": `layer ${i}`},
        act("↑ to the front", "up", {do: "move", layer: i, to: i - 1}, "moved", i === 0),
        act("↓ to the back", "down", {do: "move", layer: i, to: i + 1}, "moved", i === last),
        act("Copy", "copy", {do: "copy", layer: i}, "copied"),
        act("Remove", "remove", {do: "remove", layer: i}, "removed", last === 0)),
      pair("name", name), pair("material", material), pair("type", type),
      make("p", {class: "wrong", id: `at-layers-${i}-name-wrong`, hidden: true}),
      make("p", {class: "wrong", id: `at-layers-${i}-material-wrong`, hidden: true}),
      make("p", {class: "wrong", id: `at-layers-${i}-type-wrong`, hidden: true}),
      ...layer.fields.map(one => control(one)), pair("contact behind", contact)));
  details.addEventListener("toggle", () => { if (details.open) { state.open = i; keep(); showDrawing(); } });
  return make("li", {}, details);
}
function materialSelect(id, chosen) {
  const groups = new Map();
  for (const one of start.materials) {
    const [group, ...rest] = one.name.split("/");
    const key = rest.length ? group : "of this file";
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(make("option", {value: one.name, title: one.source}, `${rest.length ? rest.join(" ") : one.name} (${one.type.replaceAll("_", " ")})`));
  }
  const select = make("select", {id}, make("option", {value: ""}, "none: values of its own"), ...[...groups].map(([label, options]) => make("optgroup", {label}, ...options)));
  if (chosen && ![...select.options].some(one => one.value === chosen)) select.append(make("option", {value: chosen}, chosen));
  select.value = chosen;
  return select;
}
function length(metres) {
  return metres >= 1 ? `${short(metres)} m` : metres >= 1e-3 ? `${short(metres * 1e3)} mm` : `${short(metres * 1e6)} µm`;
}
function showSummaries() {
  described.layers.forEach((layer, i) => {
    const thick = document.querySelector(`#layer-${i} .thick`);
    if (thick) thick.textContent = layer.thickness === null ? "sheet" : length(layer.thickness);
  });
}

// -- the drawing ----------------------------------------------------------------------------------------------------

function patterns() {
  const tile = (id, size, ...marks) => draw("pattern", {id, width: size, height: size, patternUnits: "userSpaceOnUse"},
    draw("rect", {width: size, height: size, class: "ground"}), ...marks);
  const line = path => draw("path", {d: path, class: "mark"});
  const dot = (x, y) => draw("circle", {cx: x, cy: y, r: 1.1, class: "dot"});
  return draw("defs", {},
    tile("pores", 9, dot(2, 2.5), dot(6.5, 7)),
    tile("hatch", 8, line("M-2 2 L2 -2 M0 8 L8 0 M6 10 L10 6")),
    tile("holes", 8, line("M0 4 H8")),
    tile("wall", 7, line("M-2 2 L2 -2 M0 7 L7 0 M5 9 L9 5")));
}
function showDrawing() {
  const box = $("drawing"), layers = described?.layers;
  const width = Math.max(260, box.clientWidth), height = 168, top = 30, bottom = 138, left = 74, right = width - 58;
  if (!layers) return;
  const total = layers.reduce((sum, one) => sum + (one.thickness || 0), 0);
  const room = right - left, least = 3;
  let scale = total > 0 ? room / total : 0, widened = false;
  const wide = layers.map(one => Math.max(least, (one.thickness || 0) * scale));
  const over = wide.reduce((sum, one) => sum + one, 0);
  if (over > room + 0.5) { // what is drawn wider than it is takes room from the others
    const fixed = wide.filter(one => one <= least).length * least;
    scale *= Math.max(0.1, (room - fixed) / Math.max(1, over - fixed));
  }
  const svg = draw("svg", {viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `stack of ${layers.length} layers, ${length(total)}: ${layers.map(one => one.title).join(", ")}`}, patterns());
  let x = left;
  const badges = [];
  layers.forEach((layer, i) => {
    const exact = (layer.thickness || 0) * scale, w = Math.max(least, exact);
    if (layer.thickness && exact < least) widened = true;
    const slab = draw("rect", {x, y: top, width: w, height: bottom - top, class: `slab ${layer.look}${i === state.open ? " picked" : ""}`,
      onclick: () => pick(i)}, draw("title", {}, `${i} ${layer.title}, ${layer.thickness === null ? "sheet" : length(layer.thickness)}`));
    svg.append(slab);
    badges.push({x: x + w / 2, i});
    x += w;
  });
  svg.append(...behindDrawn(x, top, bottom, width));
  // numbers above; neighbours that would touch are moved apart
  const gap = 19;
  badges.forEach((one, k) => { one.at = k ? Math.max(one.x, badges[k - 1].at + gap) : one.x; });
  for (let k = badges.length - 1, edge = width - 12; k >= 0; k--) { badges[k].at = Math.min(badges[k].at, edge); edge = badges[k].at - gap; }
  for (const one of badges) {
    const picked = one.i === state.open;
    svg.append(draw("path", {d: `M${one.at} 19 L${one.x} ${top}`, class: "rule", fill: "none"}),
      draw("circle", {cx: one.at, cy: 11, r: 8.5, class: picked ? "picked-badge" : "badge"}),
      draw("text", {x: one.at, y: 15, "text-anchor": "middle", class: picked ? "picked-number" : ""}, String(one.i)));
  }
  svg.append(...soundDrawn(left, top, bottom), ...ruler(left, bottom + 14, scale, room));
  box.replaceChildren(svg);
  $("scale").textContent = `${length(total)} in all${widened ? "; layers thinner than the pen are drawn wider than they are" : ""}`;
}
function pick(i) {
  const details = $(`layer-${i}`);
  document.querySelectorAll("#layers details").forEach((one, k) => { if (k !== i) one.open = false; });
  details.open = true;
  state.open = i;
  details.scrollIntoView({block: "nearest"});
  showDrawing();
}
function behindDrawn(x, top, bottom, width) {
  const behind = state.data.termination ?? "rigid";
  if (behind === "rigid") return [draw("rect", {x, y: top, width: 14, height: bottom - top, class: "wall"}), draw("path", {d: `M${x} ${top} V${bottom}`, stroke: "currentColor", "stroke-width": 2}),
    draw("text", {x: x + 18, y: (top + bottom) / 2 + 4, class: "faint"}, "wall")];
  const label = behind === "ambient" ? "air" : behind === "free" ? "free" : "fluid";
  const y = (top + bottom) / 2, out = label === "free" ? [] : [draw("path", {d: `M${x + 6} ${y - 18} H${x + 30}`, class: "ray"}), draw("path", {d: `M${x + 30} ${y - 22} l7 4 l-7 4 z`, class: "head"})];
  return [...out, draw("text", {x: x + 8, y: y + 6, class: "faint"}, label)];
}
function soundDrawn(left, top, bottom) {
  const {kind, angle} = incidence(), y = (top + bottom) / 2;
  const angles = kind === "diffuse" ? [-angle, -angle / 2, 0, angle / 2, angle] : [angle];
  const arrows = angles.flatMap(one => {
    const turn = `translate(${left - 4} ${y}) rotate(${one})`;
    return [draw("path", {d: "M-44 0 H-9", class: "ray", transform: turn}), draw("path", {d: "M-9 -4 L0 0 L-9 4 z", class: "head", transform: turn})];
  });
  return [...arrows, draw("text", {x: 2, y: bottom - 2, class: "faint"}, "sound")];
}
function ruler(x, y, scale, room) {
  if (!(scale > 0)) return [];
  const wished = room / scale / 4, power = 10 ** Math.floor(Math.log10(wished));
  const size = [5, 2, 1].map(one => one * power).find(one => one <= wished) ?? power, w = size * scale;
  return [draw("path", {d: `M${x} ${y - 4} V${y + 4} M${x} ${y} H${x + w} M${x + w} ${y - 4} V${y + 4}`, class: "rule", fill: "none"}),
    draw("text", {x: x + w + 6, y: y + 4, class: "faint"}, length(size))];
}

// -- the sound field, frequencies, size -----------------------------------------------------------------------------

function degrees(given) { // a bare number, or one with its unit
  const number = parseFloat(given) || 0;
  return /[\d. ]rad/.test(given) ? Number((number * 180 / Math.PI).toPrecision(4)) : number;
}
function incidence(data = state.data) { // as drawn and chosen; what a file may write is more
  const given = data.incidence ?? "normal";
  if (given === "normal" || given === 0) return {kind: "normal", angle: 0};
  if (given === "diffuse") return {kind: "diffuse", angle: 78};
  if (typeof given === "object") return {kind: "diffuse", angle: degrees(given.diffuse?.max_angle ?? 78)};
  return {kind: "oblique", angle: degrees(given)};
}
function setIncidence(kind, angle, edit = "") {
  const data = copied(state.data), before = data.incidence;
  if (kind === "normal") data.incidence = "normal";
  else if (kind === "oblique") data.incidence = angle;
  else data.incidence = {diffuse: {...(typeof before === "object" && before !== null ? before.diffuse : {}), max_angle: angle}};
  return change(data, edit);
}
let angleKind = "";
function showField() {
  const {kind, angle} = incidence();
  document.querySelectorAll("[name=incidence]").forEach(one => { one.checked = one.value === kind; });
  const termination = state.data.termination ?? "rigid";
  $("termination").value = typeof termination === "object" ? "fluid" : termination;
  if (kind !== angleKind) {
    angleKind = kind;
    $("angle").replaceChildren(...(kind === "normal" ? [] : [angleControl(kind)]));
  }
  const slider = $("angle").querySelector("input");
  if (slider && document.activeElement !== slider) { slider.value = angle; slider.dispatchEvent(new Event("shown")); }
}
function angleControl(kind) {
  const label = kind === "oblique" ? "angle from the normal" : "largest angle";
  const output = make("output", {});
  const slider = make("input", {type: "range", min: kind === "oblique" ? 0 : 30, max: kind === "oblique" ? 89 : 90, step: 1, id: "angle-slider", "aria-label": label});
  const tell = () => { output.textContent = `${slider.value}°`; slider.setAttribute("aria-valuetext", `${slider.value} degrees`); };
  slider.addEventListener("shown", tell);
  slider.addEventListener("input", () => { tell(); if (setIncidence(kind, Number(slider.value), "angle")) { showDrawing(); follow(); } });
  oneStepEach(slider, "angle");
  return make("label", {}, `${label} `, output, slider);
}
function showFrequencies() {
  const given = state.data.frequency ?? {}, box = $("frequencies");
  const bands = given.third_octaves ? "third_octaves" : given.octaves ? "octaves" : "";
  if (Array.isArray(given)) {
    box.replaceChildren(make("p", {class: "note"}, `${given.length} frequencies, as listed in the file`));
    return;
  }
  const ends = bands ? given[bands] : [given.from ?? given.start ?? 89.13, given.to ?? given.stop ?? 5623];
  const kind = make("select", {id: "frequency-kind"}, make("option", {value: ""}, "single frequencies"), make("option", {value: "third_octaves"}, "third octaves"), make("option", {value: "octaves"}, "octaves"));
  kind.value = bands;
  const box_ = (id, value) => { const one = make("input", {type: "text", id, spellcheck: "false", autocomplete: "off"}); one.value = typeof value === "number" ? `${value} Hz` : value; return one; };
  const low = box_("at-frequency-from", ends[0]), high = box_("at-frequency-to", ends[1]);
  const points = make("input", {type: "text", id: "at-frequency-points", inputmode: "numeric"});
  points.value = given.points ?? 200;
  const set = () => {
    const number = one => (bare.test(one.value) ? Number(one.value) : one.value.trim()), data = copied(state.data);
    if (kind.value) data.frequency = {[kind.value]: [number(low), number(high)]};
    else data.frequency = {from: number(low), to: number(high), points: number(points), ...(given.spacing ? {spacing: given.spacing} : {})};
    if (change(data)) refresh(true);
  };
  [kind, low, high, points].forEach(one => one.addEventListener("change", set));
  const pair = (label, input) => make("div", {}, make("div", {class: "pair"}, make("label", {for: input.id}, label), input), make("p", {class: "wrong", id: input.id + "-wrong", hidden: true}));
  box.replaceChildren(pair("as", kind), pair("from", low), pair("to", high), ...(bands ? [] : [pair("points", points)]));
}
function showSize() {
  const given = state.data.finite_size;
  const box = name => {
    const one = make("input", {type: "text", id: `at-finite_size-${name}`, spellcheck: "false", autocomplete: "off", placeholder: "infinite"});
    one.value = given ? (typeof given[name] === "number" ? `${given[name]} m` : given[name] ?? "") : "";
    return one;
  };
  const width = box("width"), height = box("height");
  const set = () => {
    const data = copied(state.data), value = one => (bare.test(one.value) ? Number(one.value) : one.value.trim());
    delete data.finite_size;
    if (width.value.trim() && height.value.trim()) data.finite_size = {width: value(width), height: value(height)};
    else if (width.value.trim() || height.value.trim()) { say("width and height belong together: give both, or none"); return; }
    if (change(data)) refresh(true);
  };
  [width, height].forEach(one => one.addEventListener("change", set));
  const pair = (label, input) => make("div", {}, make("div", {class: "pair"}, make("label", {for: input.id}, label), input), make("p", {class: "wrong", id: input.id + "-wrong", hidden: true}));
  $("size").replaceChildren(pair("width", width), pair("height", height));
}

// -- curves ---------------------------------------------------------------------------------------------------------

function showResult() {
  if (!result || !result.curves) return;
  showDrawing();
  showRatings();
  $("left-out").textContent = [
    result.left_out ? `Drawn at ${result.frequency.length} of ${result.frequency.length + result.left_out} frequencies.` : "",
    described?.aside.length ? `The file's ${described.aside.join(" and ")} stay${described.aside.length > 1 ? "" : "s"} in it and ${described.aside.length > 1 ? "are" : "is"} not drawn.` : "",
  ].join(" ");
  showLegend();
  showShown();
  showCharts();
}
function showRatings() {
  const last = state.frozen[state.frozen.length - 1];
  const field = incidenceText(incidence(result.data));
  const entries = Object.entries(result.ratings).map(([name, value]) => make("div", {},
    make("dt", {}, `${name}, ${field}`), make("dd", {}, value, last && last.ratings[name] ? make("span", {class: "before"}, ` before ${last.ratings[name]}`) : null)));
  if (!entries.length) entries.push(make("div", {}, make("dt", {}, "ratings"), make("dd", {class: "before"}, "need whole third octaves from 100 Hz to 5 kHz")));
  const text = entries.map(one => one.textContent).join();
  if ($("ratings").dataset.text !== text) { $("ratings").replaceChildren(...entries); $("ratings").dataset.text = text; }
}
const incidenceText = ({kind, angle}) => (kind === "normal" ? "normal" : kind === "oblique" ? `${angle}°` : `diffuse to ${angle}°`);
async function freeze() {
  while (!ended && rested !== state.data) await refresh(); // curves and ratings of one design
  if (!result || problems.length) { say("there is no curve to freeze"); return; }
  if (state.frozen.length === MOST_FROZEN) state.frozen.shift();
  const used = state.frozen.map(one => one.colour), colour = [0, 1, 2, 3].find(one => !used.includes(one));
  state.frozen.push({colour, label: `frozen ${"ABCD"[colour]}`, field: incidenceText(incidence(result.data)), data: copied(result.data),
    frequency: result.frequency, curves: result.curves, ratings: result.ratings});
  keep();
  showResult();
  say("curve frozen");
}
function showLegend() {
  const items = [make("li", {}, make("span", {class: "swatch now"}), "now")];
  state.frozen.forEach((one, i) => items.push(make("li", {},
    make("span", {class: `swatch c${one.colour}`}), `${one.label}, ${one.field}`,
    make("button", {type: "button", class: "small", id: `back-${one.colour}`, title: "make this the design again; can be undone",
      onclick: () => { if (change(copied(one.data))) renew(); say(`${one.label} is the design again`); }}, "Go back to it"),
    make("button", {type: "button", class: "small", "aria-label": `take ${one.label} away`,
      onclick: () => { state.frozen.splice(i, 1); keep(); showResult(); $("freeze").focus(); }}, "×"))));
  for (const one of start.measured) items.push(make("li", {}, make("span", {class: "swatch dots m"}), `${one.name}, measured`));
  const text = items.map(one => one.textContent).join();
  if ($("curves").dataset.text !== text) { $("curves").replaceChildren(...items); $("curves").dataset.text = text; }
}
function showShown() {
  const names = Object.entries(result.curves).map(([name, one]) => [name, one.title]), text = JSON.stringify(names);
  if ($("shown").dataset.text === text) return;
  $("shown").dataset.text = text;
  const boxes = names.map(([name, title]) => {
    const box = make("input", {type: "checkbox", id: `show-${name}`});
    box.checked = !state.hidden.includes(name);
    box.addEventListener("change", () => {
      state.hidden = state.hidden.filter(one => one !== name);
      if (!box.checked) state.hidden.push(name);
      keep();
      showCharts();
    });
    return make("label", {}, box, ` ${title}`);
  });
  $("shown").replaceChildren(make("legend", {}, "Show"), ...boxes);
}
function series(name) {
  const all = [{class: "now", label: "now", frequency: result.frequency, parts: result.curves[name].parts}];
  for (const one of state.frozen) if (one.curves[name]) all.unshift({class: `c${one.colour}`, label: one.label, frequency: one.frequency, parts: one.curves[name].parts});
  for (const one of start.measured) if (one.curves[name]) all.unshift({class: "m", label: one.name, dots: true, frequency: one.frequency, parts: one.curves[name].parts});
  return all;
}
function limits(name, all) {
  const values = all.flatMap(one => one.parts.flatMap(part => part.values)).filter(one => one !== null).sort((a, b) => a - b);
  if (!values.length) return [0, 1];
  if (name === "absorption") return [Math.min(0, values[0]), Math.max(1, values[values.length - 1])];
  const complex = result.curves[name].parts.length > 1;
  const trim = complex ? 0.03 : 0; // of an impedance the poles alone would be seen
  let low = values[Math.floor(trim * (values.length - 1))], high = values[Math.ceil((1 - trim) * (values.length - 1))];
  low = Math.min(low, 0);
  high = Math.max(high, name.includes("loss") ? 10 : low + 1);
  return toTicks(low, high);
}
let cursor = null; // Hz
function showCharts() {
  if (!result) return;
  const losses = name => (name.endsWith("_loss") ? 0 : 1); // of a stack that lets sound through they come first
  const names = Object.keys(result.curves).filter(name => !state.hidden.includes(name)).sort((a, b) => losses(a) - losses(b)), box = $("charts");
  box.classList.toggle("many", names.length > 1);
  while (box.children.length > names.length) box.lastChild.remove();
  while (box.children.length < names.length) box.append(make("div", {class: "chart", tabindex: -1}, make("h3"), make("div")));
  names.forEach((name, i) => {
    const heading = box.children[i].firstChild, one = result.curves[name];
    if (box.children[i].dataset.name !== name) {
      box.children[i].dataset.name = name;
      heading.replaceChildren(make("span", {}, one.title + (one.unit ? ` / ${one.unit}` : ""), one.parts.length > 1 ? make("span", {class: "note"}, "  real —, imaginary - -") : null), make("span", {class: "read"}));
    }
  });
  names.forEach((name, i) => { const box_ = box.children[i].lastChild; box_.replaceChildren(chart(name, box_.clientWidth)); });
  showReading();
}
const ends = () => [result.frequency[0], result.frequency[result.frequency.length - 1]];
function chart(name, wide) {
  const width = Math.max(240, wide), at = axes(width, ...ends()), all = series(name);
  const {svg, inside, y} = frame(name, result.curves[name].title, width, at, limits(name, all), share => {
    cursor = at.frequency(share);
    $("read-at").value = STEPS * share;
    showReading();
  });
  for (const one of all) one.parts.forEach((part, k) => {
    const points = one.frequency.map((f, i) => [f, part.values[i]]).filter(([f, v]) => v !== null && f >= at.low * 0.999 && f <= at.high * 1.001);
    if (one.dots) inside.append(...points.map(([f, v]) => draw(k ? "rect" : "circle", k ? {x: at.x(f) - 2.2, y: y(v) - 2.2, width: 4.4, height: 4.4, class: `point ${one.class}`} : {cx: at.x(f), cy: y(v), r: 2.6, class: `point ${one.class}`})));
    else inside.append(draw("path", {d: line(points, at, y), class: `curve ${one.class}${k ? " im" : ""}`}));
  });
  return svg;
}
function showReading() {
  if (!result) return;
  const all = result.frequency, low = all[0], high = all[all.length - 1], share = $("read-at").value / STEPS;
  if (cursor === null || cursor < low || cursor > high) cursor = low * (high / low) ** share;
  const i = nearest(all, cursor), f = all[i];
  $("read-frequency").textContent = hertz(f);
  $("read-at").setAttribute("aria-valuetext", hertz(f));
  for (const box of $("charts").children) {
    const name = box.dataset.name, svg = box.querySelector("svg");
    if (!svg || !result.curves[name]) continue;
    const at = axes(svg.viewBox.baseVal.width, ...ends());
    svg.querySelector(".cursor").setAttribute("d", `M${at.x(f)} ${at.top} V${at.bottom}`);
    const values = series(name).reverse().map(one => {
      const j = nearest(one.frequency, f);
      if (Math.abs(Math.log(one.frequency[j] / f)) > 0.15) return null;
      const [re, im] = one.parts.map(part => part.values[j]);
      const text = im === undefined ? short(re) : `${short(re)} ${im < 0 ? "−" : "+"} ${short(Math.abs(im))}i`;
      return make("span", {class: one.class}, text);
    }).filter(Boolean);
    box.querySelector(".read").replaceChildren(`${hertz(f)}: `, ...values.flatMap((one, k) => (k ? [", ", one] : [one])));
  }
}

// -- saving and the file on the disk --------------------------------------------------------------------------------

let replacing = false;
function askSave() {
  replacing = false;
  $("save-do").textContent = "Save";
  $("save-problem").textContent = "";
  $("save-name").value = $("save-name").value || start.file.replace(/\.ya?ml$/i, "")
    .replace(/[^\p{L}\p{N}_ .+=,()-]/gu, "-").replace(/^[^\p{L}\p{N}]+/u, "").slice(0, 100) + "-explored.yaml"; // as a file may be named
  $("keep-aside").hidden = !described?.aside.length;
  $("saving").showModal();
  $("save-name").select();
}
async function doSave() {
  const kind = document.querySelector("[name=kind]:checked").value;
  const answer = await ask("save", {data: state.data, name: $("save-name").value.trim(), kind, replace: replacing, known: state.digest, aside: $("aside").checked});
  if (!answer) { $("saving").close(); return; }
  if (answer.problems.length) {
    $("save-problem").textContent = answer.problems.map(one => (one.path ? `${one.path}: ` : "") + one.text).join("\n");
    replacing = Boolean(answer.taken);
    $("save-do").textContent = replacing ? "Replace it" : "Save";
    return;
  }
  state.digest = answer.digest;
  state.saved = JSON.stringify(state.data);
  $("saving").close();
  showHistory();
  say(`saved as ${answer.name}`);
}
async function readAgain() {
  const answer = await ask("start");
  if (!answer) return;
  changedTo = "";
  if (answer.problems?.length) { said = answer.problems.map(one => one.text); showBanners(); return; }
  start = answer;
  change(answer.data);
  state.digest = answer.digest;
  state.saved = JSON.stringify(answer.data);
  said = [];
  showHistory();
  renew();
  say("read again; undo brings back what was here");
}
async function watch() {
  if (!document.hidden) {
    const answer = await ask("watch");
    if (answer) {
      const now = answer.digest === state.digest ? "" : answer.digest || "gone";
      const told = now === state.ignored ? "" : now;
      if (told !== changedTo) { changedTo = told; showBanners(); }
      if (made !== renewed && !asking) refresh(); // what to show was not to be had
    }
  }
  setTimeout(watch, WATCHED);
}

// -- beginning ------------------------------------------------------------------------------------------------------

function addChoices() {
  const byType = make("optgroup", {label: "types, with typical values"}, ...start.types.map(one => make("option", {value: `type ${one.name}`, title: one.summary}, one.name.replaceAll("_", " "))));
  const groups = [...materialSelect("unused", "").querySelectorAll("optgroup")];
  groups.forEach(group => group.querySelectorAll("option").forEach(one => { one.value = `material ${one.value}`; }));
  $("new").replaceChildren(byType, ...groups);
}
function listen() {
  $("undo").addEventListener("click", undo);
  $("redo").addEventListener("click", redo);
  $("save").addEventListener("click", askSave);
  $("freeze").addEventListener("click", freeze);
  $("save-cancel").addEventListener("click", () => $("saving").close());
  $("save-name").addEventListener("input", () => { replacing = false; $("save-do").textContent = "Save"; });
  $("saving").querySelector("form").addEventListener("submit", event => { event.preventDefault(); doSave(); });
  $("add").addEventListener("submit", event => {
    event.preventDefault();
    const [kind, ...name] = $("new").value.split(" ");
    edit({do: "add", at: Number($("where").value), [kind]: name.join(" ")}, "layer added");
  });
  document.querySelectorAll("[name=incidence]").forEach(one => one.addEventListener("change", () => {
    const angle = {normal: 0, oblique: 45, diffuse: 78}[one.value];
    if (setIncidence(one.value, angle)) { showField(); refresh(true); }
  }));
  $("termination").addEventListener("change", () => {
    const data = copied(state.data), chosen = $("termination").value;
    data.termination = chosen === "fluid" ? {type: "fluid", density: 1000, sound_speed: 1480} : chosen;
    if (change(data)) refresh(true);
  });
  $("read-at").addEventListener("input", () => {
    const all = result.frequency, low = all[0], high = all[all.length - 1];
    cursor = low * (high / low) ** ($("read-at").value / STEPS);
    showReading();
  });
  document.addEventListener("keydown", event => {
    const typing = event.target.matches?.("input[type=text], textarea"), key = event.key.toLowerCase();
    const control = event.ctrlKey || event.metaKey;
    if (control && key === "s") { event.preventDefault(); if (!$("saving").open) askSave(); }
    else if (typing || $("saving").open) return;
    else if (control && key === "z") { event.preventDefault(); (event.shiftKey ? redo : undo)(); }
    else if (control && key === "y") { event.preventDefault(); redo(); }
    else if (!control && !event.altKey && key === "f" && !event.target.matches?.("select")) freeze();
    else if (event.altKey && (key === "arrowup" || key === "arrowdown")) {
      const details = event.target.closest?.("#layers details");
      if (!details) return;
      event.preventDefault();
      $(`${details.id}-${key === "arrowup" ? "up" : "down"}`).click();
    }
  });
  window.addEventListener("beforeunload", event => { if (isUnsaved()) event.preventDefault(); });
  onResize(showResult);
}
async function begin() {
  start = await ask("start");
  if (!start) return;
  let kept = null;
  try { kept = JSON.parse(sessionStorage.getItem(KEPT)); } catch { /* nothing was kept */ }
  const wrong = (start.problems ?? []).map(one => one.text);
  if (!start.types || !(start.data ?? kept?.data)) { said = wrong; showBanners(); return; }
  said = start.data ? start.warnings : [...wrong, "This window goes on with the design that it has kept."];
  $("file").textContent = start.file;
  const isStack = Object.keys(start.data ?? kept.data).every(key => ["version", "ambient", "library", "layers", "contacts", "termination"].includes(key));
  document.querySelector(`[name=kind][value=${isStack ? "stack" : "simulation"}]`).checked = true;
  document.title = `${start.file}: multilayer explore`;
  if (kept?.data) Object.assign(state, kept);
  else Object.assign(state, {data: start.data, digest: start.digest, saved: JSON.stringify(start.data), file: start.file});
  addChoices();
  listen();
  showHistory();
  await refresh(true);
  document.body.dataset.ready = "yes";
  watch();
}
begin();
