// SPDX-License-Identifier: BSD-3-Clause
// The plot of the steps: choose what is shown, drag over a range to look into it, double-click to see all again, point at a step for its numbers.
(() => {
  "use strict";
  const { time, columns, data, total } = JSON.parse(document.getElementById("history").textContent);
  const host = document.getElementById("steps");
  const names = { time, attempt: "number of the attempt", ...columns };
  const width = 1040, height = 380, left = 78, right = 16, top = 14, bottom = 46;
  const accepted = "#0072B2", rejected = "#D55E00", faint = "#DDDDDD";
  const state = { x: "time", y: "dt", log: true, range: null };

  const make = (tag, attributes, parent, text) => {
    const svg = ["svg", "g", "path", "line", "text", "rect", "circle", "clipPath", "defs"].includes(tag);
    const e = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
    for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
    if (text !== undefined) e.textContent = text;
    if (parent) parent.append(e);
    return e;
  };

  const controls = make("div", { class: "controls" }, host);
  const choice = (label, options, key) => {
    const l = make("label", {}, controls, label + " ");
    const s = make("select", { id: "choose-" + key }, l);
    for (const o of options) make("option", { value: o }, s, names[o]);
    s.value = state[key];
    s.addEventListener("change", () => { state[key] = s.value; state.range = key === "x" ? null : state.range; draw(); });
  };
  choice("show", Object.keys(columns), "y");
  choice("over", ["time", "attempt"], "x");
  const l = make("label", {}, controls);
  const box = make("input", { type: "checkbox", id: "choose-log" }, l);
  box.checked = state.log;
  l.append(" logarithmic");
  box.addEventListener("change", () => { state.log = box.checked; draw(); });
  const all = make("button", { type: "button", id: "show-all" }, controls, "show all");
  all.addEventListener("click", () => { state.range = null; draw(); });
  const svg = make("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "history of the steps" }, host);
  const shown = data.time.length < total ? `${data.time.length} of ${total} attempts are shown: the extremes, and those rejected. ` : "";
  const help = make("div", { class: "help" }, host, shown + "Drag over a range to look into it; point at a step for its numbers.");

  const number = (v) => (v === null ? "-" : Math.abs(v) >= 1e5 || (v !== 0 && Math.abs(v) < 1e-3) ? v.toExponential(3) : String(+v.toPrecision(5)));
  const ticks = (low, high) => {
    const raw = (high - low) / 6, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((m) => m * power >= raw) * power;
    const list = [];
    for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; ++k) list.push(k * step);
    return list;
  };
  const decades = (low, high) => {
    const list = [], stride = Math.max(1, Math.ceil((high - low) / 7));
    for (let k = Math.ceil(low); k <= high; k += stride) list.push(k);
    return list.length > 1 ? list : ticks(low, high);
  };

  let points = [], toX = null, fromX = null, marker = null, band = null, begun = null;

  function draw() {
    svg.replaceChildren();
    const xs = data[state.x], ys = data[state.y];
    const [low, high] = state.range || [Math.min(...xs), Math.max(...xs)];
    const inside = xs.map((x, i) => x >= low && x <= high && ys[i] !== null && (!state.log || ys[i] > 0));
    const f = state.log ? Math.log10 : (v) => v;
    const values = ys.filter((_, i) => inside[i]).map(f);
    if (!values.length) {
      make("text", { x: width / 2, y: height / 2, "text-anchor": "middle" }, svg, state.log ? "nothing positive to show here" : "nothing to show here");
      points = [];
      return;
    }
    let least = Math.min(...values), most = Math.max(...values);
    if (state.log && most - least < 1) { const m = 0.5 * (most + least); least = m - 0.5; most = m + 0.5; }
    if (most === least) { most += Math.abs(most) || 1; least -= state.log ? 1 : Math.abs(least); }
    const pad = 0.05 * (most - least);
    least -= pad; most += pad;
    toX = (x) => left + (width - left - right) * (x - low) / ((high - low) || 1);
    fromX = (p) => low + (p - left) / (width - left - right) * (high - low);
    const toY = (v) => height - bottom - (height - top - bottom) * (v - least) / (most - least);

    for (const v of state.log ? decades(least, most) : ticks(least, most)) {
      make("line", { x1: left, x2: width - right, y1: toY(v), y2: toY(v), stroke: faint }, svg);
      const label = state.log ? (Number.isInteger(v) ? `1e${v}` : number(+(10 ** v).toPrecision(3))) : number(v);
      make("text", { x: left - 6, y: toY(v) + 4, "text-anchor": "end", "font-size": 12 }, svg, label);
    }
    for (const v of ticks(low, high)) {
      make("line", { x1: toX(v), x2: toX(v), y1: top, y2: height - bottom, stroke: faint }, svg);
      make("text", { x: toX(v), y: height - bottom + 17, "text-anchor": "middle", "font-size": 12 }, svg, number(v));
    }
    make("rect", { x: left, y: top, width: width - left - right, height: height - top - bottom, fill: "none", stroke: "#555" }, svg);
    make("text", { x: (left + width - right) / 2, y: height - 8, "text-anchor": "middle", "font-size": 13 }, svg, names[state.x]);
    const turn = `translate(16 ${(top + height - bottom) / 2}) rotate(-90)`;
    make("text", { transform: turn, "text-anchor": "middle", "font-size": 13 }, svg, names[state.y]);

    points = [];
    let path = "";
    const crosses = make("g", { stroke: rejected, "stroke-width": 1.6, class: "rejected" }, svg);
    xs.forEach((x, i) => {
      if (!inside[i]) return;
      const p = { i, x: toX(x), y: toY(f(ys[i])) };
      points.push(p);
      if (data.accepted[i]) {
        path += `${path ? "L" : "M"}${p.x.toFixed(1)} ${p.y.toFixed(1)}`;
      } else {
        make("path", { d: `M${p.x - 4} ${p.y - 4}l8 8m0 -8l-8 8` }, crosses);
      }
    });
    make("path", { d: path, fill: "none", stroke: accepted, "stroke-width": 1.3, class: "accepted" }, svg);
    if (points.length < 120) {
      for (const p of points) if (data.accepted[p.i]) make("circle", { cx: p.x, cy: p.y, r: 2.2, fill: accepted }, svg);
    }
    svg.append(crosses);
    make("line", { x1: width - 230, x2: width - 205, y1: top + 14, y2: top + 14, stroke: accepted, "stroke-width": 2 }, svg);
    make("text", { x: width - 200, y: top + 18, "font-size": 12 }, svg, "accepted");
    make("path", { d: `M${width - 130} ${top + 10}l8 8m0 -8l-8 8`, stroke: rejected, "stroke-width": 1.6 }, svg);
    make("text", { x: width - 115, y: top + 18, "font-size": 12 }, svg, "rejected");
    marker = make("circle", { r: 5, fill: "none", stroke: "#000", visibility: "hidden" }, svg);
    band = make("rect", { y: top, height: height - top - bottom, fill: accepted, "fill-opacity": 0.15, visibility: "hidden" }, svg);
  }

  const place = (event) => {
    const r = svg.getBoundingClientRect();
    return { x: Math.min(Math.max((event.clientX - r.left) * width / r.width, left), width - right), y: (event.clientY - r.top) * height / r.height };
  };
  svg.addEventListener("pointerdown", (event) => { if (points.length) { begun = place(event).x; svg.setPointerCapture(event.pointerId); } });
  svg.addEventListener("pointermove", (event) => {
    if (!points.length) return;
    const at = place(event);
    if (begun !== null) {
      band.setAttribute("x", Math.min(begun, at.x));
      band.setAttribute("width", Math.abs(at.x - begun));
      band.setAttribute("visibility", "visible");
      return;
    }
    const near = points.reduce((a, b) => ((b.x - at.x) ** 2 + (b.y - at.y) ** 2 < (a.x - at.x) ** 2 + (a.y - at.y) ** 2 ? b : a));
    marker.setAttribute("cx", near.x);
    marker.setAttribute("cy", near.y);
    marker.setAttribute("visibility", "visible");
    const facts = Object.keys(columns).map((k) => `${columns[k]} ${number(data[k][near.i])}`);
    help.textContent = `attempt ${data.attempt[near.i]} at t = ${number(data.time[near.i])}, ${data.accepted[near.i] ? "accepted" : "rejected"}: ${facts.join(", ")}`;
  });
  svg.addEventListener("pointerup", (event) => {
    const end = place(event).x;
    if (begun !== null && Math.abs(end - begun) > 4) {
      state.range = [fromX(Math.min(begun, end)), fromX(Math.max(begun, end))];
      draw();
    }
    begun = null;
    if (band) band.setAttribute("visibility", "hidden");
  });
  svg.addEventListener("dblclick", () => { state.range = null; draw(); });
  draw();
})();
