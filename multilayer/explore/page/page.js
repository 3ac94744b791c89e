// What the pages of `multilayer explore` share. Texts become text nodes and attributes, never markup. A page's own script
// comes after this one and has a function `showBanners`.
"use strict";

const $ = id => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";

const MOST_PAST = 300;
let ended = false; // the command; nothing is computed any more

// -- small things ---------------------------------------------------------------------------------------------------

function make(name, attributes = {}, ...children) {
  return filled(document.createElement(name), attributes, children);
}
function draw(name, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, name), attributes, children);
}
function filled(element, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== undefined && value !== null && value !== false) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.filter(child => child !== null && child !== undefined));
  return element;
}
const copied = value => JSON.parse(JSON.stringify(value));
function short(value, digits = 3) {
  if (value === null || !Number.isFinite(value)) return "–";
  const text = Number(value.toPrecision(digits));
  return Math.abs(text) >= 1e5 || (text !== 0 && Math.abs(text) < 1e-4) ? text.toExponential().replace("e+", "e") : String(text);
}
const hertz = value => value >= 1000 ? `${short(value / 1000)} kHz` : `${short(value)} Hz`;
function say(text) { $("status").textContent = `${text[0].toUpperCase()}${text.slice(1)}.`; }
function remember(state, before, edit) { // one step of the history for each edit
  if (!edit || edit !== state.edit) {
    state.past.push(before);
    state.past.splice(0, state.past.length - MOST_PAST);
  }
  state.edit = edit;
  state.future = [];
}
function oneStepEach(slider, edit) { // each drag by itself; keys as long as they stay on the slider
  slider.addEventListener("blur", () => { if (state.edit === edit) state.edit = ""; });
  slider.addEventListener("pointerup", () => { state.edit = ""; });
}
function onResize(redraw) {
  let width = 0;
  new ResizeObserver(() => { if (innerWidth !== width) { width = innerWidth; redraw(); } }).observe(document.body);
  const header = document.querySelector("header");
  new ResizeObserver(() => document.body.style.setProperty("--top", `${header.offsetHeight}px`)).observe(header);
}
async function ask(question, body = {}) {
  let answer;
  try {
    const response = await fetch(question, {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(body)});
    if (!response.ok) throw new Error(`${response.status}`);
    answer = await response.json();
  } catch {
    ended = true;
    showBanners();
    return null;
  }
  if (ended) { ended = false; showBanners(); }
  return answer;
}

// -- charts ---------------------------------------------------------------------------------------------------------

function ticks(low, high, wished) {
  const rough = (high - low) / wished, power = 10 ** Math.floor(Math.log10(rough));
  const size = [1, 2, 5, 10].map(one => one * power).find(one => one >= rough);
  const first = Math.ceil(low / size - 1e-9), found = [];
  for (let k = first; k * size <= high + 1e-9 * size; k++) found.push(Number((k * size).toPrecision(12)));
  return {size, found};
}
function toTicks(low, high) { // ends of an axis that begins and ends with a tick
  const {size} = ticks(low, high, 5);
  return [Math.floor(low / size) * size, Math.ceil(high / size) * size];
}
const OCTAVES = [16, 31.5, 63, 125, 250, 500, 1000, 2000, 4000, 8000, 16000];
function axes(width, low, high) { // of a chart over frequency, Hz
  const height = innerWidth < 640 ? 175 : 230, left = 40, right = width - 12, top = 10, bottom = height - 22, isLog = high >= 4 * low;
  const x = f => (high === low ? (left + right) / 2 : left + (right - left) * (isLog ? Math.log(f / low) / Math.log(high / low) : (f - low) / (high - low)));
  const frequency = share => (isLog ? low * (high / low) ** share : low + share * (high - low));
  return {low, high, height, left, right, top, bottom, isLog, x, frequency};
}
// A chart without curves: `inside` is where these go, `y` their scale; `read` is told the share of the width pointed at.
function frame(name, title, width, at, [low, high], read) {
  const y = value => at.bottom - (at.bottom - at.top) * (value - low) / (high - low);
  const svg = draw("svg", {viewBox: `0 0 ${width} ${at.height}`, role: "img", "aria-label": `${title} over frequency, ${hertz(at.low)} to ${hertz(at.high)}`});
  const clip = `inside-${name}`;
  svg.append(draw("defs", {}, draw("clipPath", {id: clip}, draw("rect", {x: at.left, y: at.top - 1, width: at.right - at.left, height: at.bottom - at.top + 2}))));
  for (const tick of ticks(low, high, 5).found) svg.append(
    draw("path", {d: `M${at.left} ${y(tick)} H${at.right}`, class: "grid"}),
    draw("text", {x: at.left - 6, y: y(tick) + 4, "text-anchor": "end"}, short(tick, 4).replace("-", "−")));
  const marks = at.isLog ? OCTAVES.filter(one => one >= at.low && one <= at.high) : ticks(at.low, at.high, 6).found;
  let lastAt = -100;
  for (const tick of marks) {
    svg.append(draw("path", {d: `M${at.x(tick)} ${at.top} V${at.bottom}`, class: "grid"}));
    if (at.x(tick) - lastAt < 34) continue;
    lastAt = at.x(tick);
    svg.append(draw("text", {x: lastAt, y: at.bottom + 15, "text-anchor": "middle"}, tick >= 1000 ? `${short(tick / 1000)}k` : short(tick)));
  }
  svg.append(draw("text", {x: at.right, y: at.bottom + 15, "text-anchor": "end"}, at.right - lastAt > 40 ? "Hz" : ""));
  const inside = draw("g", {"clip-path": `url(#${clip})`});
  svg.append(inside, draw("path", {d: `M${at.left} ${at.top} V${at.bottom} H${at.right}`, class: "axis"}), draw("path", {class: "cursor"}));
  svg.addEventListener("pointermove", event => {
    const box = svg.getBoundingClientRect(), px = (event.clientX - box.left) * width / box.width;
    read(Math.min(1, Math.max(0, (px - at.left) / (at.right - at.left))));
  });
  return {svg, inside, y};
}
const line = (points, at, y) => points.map(([f, v], i) => `${i ? "L" : "M"}${at.x(f).toFixed(1)} ${Math.max(-2e3, Math.min(3e3, y(v))).toFixed(1)}`).join("");
function nearest(frequency, f) {
  let best = 0;
  frequency.forEach((one, i) => { if (Math.abs(Math.log(one / f)) < Math.abs(Math.log(frequency[best] / f))) best = i; });
  return best;
}
