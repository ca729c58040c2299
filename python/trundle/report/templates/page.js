"use strict";
// Values under the pointer, zoom, sorting and copying. The page is complete without this script.
const numbers = text => text.split(" ").map(Number);
const clamp = (value, low, high) => Math.min(Math.max(value, low), Math.max(low, high));
const show = value => Number(value.toPrecision(3)).toString().replace("-", "\u2212");

const add = (parent, name, attributes, text = "") => {
  const element = document.createElementNS(parent.namespaceURI, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.textContent = text;
  return parent.appendChild(element);
};

const button = (parent, text, name, action) => {
  const made = add(parent, "button", {type: "button", "aria-label": name, title: name}, text);
  made.addEventListener("click", action);
  return made;
};

const live = add(document.body, "p", {class: "unseen", "aria-live": "polite"});

const readRows = link => decodeURIComponent(link.href.slice(link.href.indexOf(",") + 1)).trim().split("\n").slice(1)
  .map(line => line.split(",").map(cell => cell === "" ? NaN : Number(cell)));

const lengthText = metres => {
  const [factor, unit] = metres < 0.01 ? [1e3, "mm"] : metres < 1 ? [1e2, "cm"] : [1, "m"];
  return `${show(metres * factor)}\u00a0${unit}`;
};

const roundTicks = (from, to) => {
  const power = 10 ** Math.floor(Math.log10((to - from) / 6));
  const step = [1, 2, 5, 10].map(factor => factor * power).find(size => (to - from) / size <= 6);
  const first = Math.ceil(from / step - 1e-9);
  return Array.from({length: Math.floor(to / step + 1e-9) - first + 1}, (_, k) => Number(((first + k) * step).toPrecision(9)));
};

// A figure: `scale` is the zoom, `time` the share of the time axis and `centre` the point of the map in its middle.
for (const figure of document.querySelectorAll("figure")) {
  const svg = figure.querySelector(":scope > svg"), link = figure.querySelector("a.data");
  const lanes = svg.querySelector(".lanes"), map = svg.querySelector(".map");
  if (!lanes && !map) continue;
  const name = svg.querySelector("title").textContent;
  const [start, end, left, width, bottom] = lanes ? numbers(lanes.dataset.frame) : [0, 1, 0, 1, 0];
  const plots = [...svg.querySelectorAll(".lanes .plot")].map(plot => [plot, numbers(plot.getAttribute("viewBox"))]);
  const axis = svg.querySelector(".time-axis"), labels = [...svg.querySelectorAll(".lanes > .number")];
  const places = labels.map(label => Number(label.getAttribute("x")));
  const bar = svg.querySelector("[data-length]");
  const size = map && numbers(map.getAttribute("viewBox")).slice(2);
  const rowsOfData = lanes ? () => rowsOfData.cache ??= readRows(link) : () => [];
  let scale = 1, time = 0.5, centre = map && size.map(side => side / 2), row = -1, cursor = null;

  const fromX = () => clamp(left + width * time - width / scale / 2, left, left + width - width / scale);
  const toPage = x => left + (x - fromX()) * scale;
  const toTime = x => start + (x - left) / width * (end - start);
  const xOf = t => left + (t - start) / (end - start) * width;
  const columnsOf = text => text.split("|").filter(Boolean).map(part => part.split(":"));

  const title = axis?.lastElementChild.textContent, unit = title?.split(", ")[1] ?? "";
  const drawAxis = () => {
    axis.replaceChildren();
    const y = Number(axis.dataset.y);
    for (const t of roundTicks(toTime(fromX()), toTime(fromX() + width / scale))) {
      const x = toPage(xOf(t));
      add(axis, "line", {x1: x, x2: x, y1: y, y2: y + 4, class: "axis"});
      add(axis, "text", {x, y: y + 16, class: "tick", "text-anchor": "middle"}, String(t).replace("-", "\u2212"));
    }
    add(axis, "text", {x: left + width, y: y + 30, class: "tick", "text-anchor": "end"}, title);
  };

  const tracksAt = values => columnsOf(map?.dataset.tracks ?? "").map(([style, x, y]) => {
    const [zoom, cx, cy] = numbers(map.dataset.scale);
    return [style, size[0] / 2 + (values[x] - cx) * zoom, size[1] / 2 - (values[y] - cy) * zoom];
  });

  const drawCursor = () => {
    cursor?.forEach(mark => mark.remove());
    cursor = [];
    const values = rowsOfData()[row];
    for (const text of svg.querySelectorAll(".readout")) {
      const found = values ? columnsOf(text.dataset.columns).filter(([column]) => Number.isFinite(values[column])) : [];
      text.textContent = found.map(([column, style]) =>
        (found.length > 1 ? `${style} ` : "") + show(values[column])).join("  ");
    }
    if (!values) return;
    const x = toPage(xOf(values[0]));
    if (x >= left - 1 && x <= left + width + 1) {
      cursor.push(add(lanes, "line", {x1: x, x2: x, y1: plots[0][1][1], y2: bottom, class: "cursor"}));
      cursor.push(add(lanes, "text", {x: left, y: bottom + 30, class: "readout"}, `${show(values[0])} ${unit}`));
    }
    for (const [style, cx, cy] of tracksAt(values))
      if (Number.isFinite(cx)) cursor.push(add(map, "circle", {cx, cy, r: 5 / scale, class: `here ${style}`}));
  };

  const draw = () => {
    for (const [plot, [, y, , height]] of plots) plot.setAttribute("viewBox", `${fromX()} ${y} ${width / scale} ${height}`);
    if (axis) drawAxis();
    labels.forEach((label, index) => {
      const x = toPage(places[index]);
      label.setAttribute("x", x);
      label.style.visibility = x < left || x > left + width ? "hidden" : "";
    });
    if (map) {
      const [x, y] = centre.map((at, k) => clamp(at - size[k] / scale / 2, 0, size[k] - size[k] / scale));
      map.setAttribute("viewBox", `${x} ${y} ${size[0] / scale} ${size[1] / scale}`);
      map.style.setProperty("--zoom", scale);
      if (bar) bar.textContent = lengthText(Number(bar.dataset.length) / scale);
    }
    drawCursor();
  };

  const zoom = factor => {
    const values = rowsOfData()[row];
    if (values) {
      time = (values[0] - start) / (end - start);
      const track = tracksAt(values)[0];
      if (track) centre = track.slice(1);
    }
    scale = clamp(scale * factor, 1, 32);
    draw();
    live.textContent = `${name}: zoom ${scale}`;
  };
  const move = (across, down) => {
    if (lanes) {
      const rows = rowsOfData();
      row = clamp(row + Math.round(across * rows.length / 100), 0, rows.length - 1);
      if (scale > 1) time = (rows[row][0] - start) / (end - start);
    } else centre = centre.map((at, k) => clamp(at + [across, down][k] * size[k] / scale / 8, 0, size[k]));
    draw();
    live.textContent = [...svg.querySelectorAll(".readout")].map(text => text.textContent).join(", ");
  };
  const pointAt = event => {
    const box = svg.getBoundingClientRect(), unit = svg.viewBox.baseVal.width / box.width;
    return [(event.clientX - box.left) * unit, (event.clientY - box.top) * unit];
  };
  const seek = event => {
    const [x] = pointAt(event), rows = rowsOfData();
    if (!lanes || (map && event.target.closest(".map"))) return;
    const t = toTime(clamp(fromX() + (x - left) / scale, left, left + width));
    row = rows.reduce((best, values, k) => Math.abs(values[0] - t) < Math.abs(rows[best][0] - t) ? k : best, 0);
    drawCursor();
  };
  const drag = event => {
    const unit = svg.viewBox.baseVal.width / svg.getBoundingClientRect().width / scale;
    if (map) centre = centre.map((at, k) => clamp(at - [event.movementX, event.movementY][k] * unit, 0, size[k]));
    if (lanes && !event.target.closest(".map")) time = clamp(time - event.movementX * unit / width, 0, 1);
    draw();
  };

  const keys = {
    "+": () => zoom(2), "=": () => zoom(2), "-": () => zoom(0.5), "0": () => zoom(1 / scale),
    ArrowLeft: () => move(-1, 0), ArrowRight: () => move(1, 0),
    ...(lanes ? {} : {ArrowUp: () => move(0, -1), ArrowDown: () => move(0, 1)}),
  };
  svg.setAttribute("tabindex", "0");
  svg.setAttribute("aria-keyshortcuts", "+ - 0 ArrowLeft ArrowRight");
  svg.addEventListener("keydown", event => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  });
  svg.addEventListener("pointermove", event => event.buttons === 1 && scale > 1 ? drag(event) : seek(event));
  svg.addEventListener("pointerdown", seek);
  svg.addEventListener("pointerleave", () => { row = -1; drawCursor(); });
  svg.addEventListener("dblclick", () => zoom(2));
  const tools = add(figure.querySelector(".tools"), "span", {});
  for (const [text, what, action] of [["+", "Zoom in", keys["+"]], ["\u2212", "Zoom out", keys["-"]], ["1:1", "Reset zoom", keys["0"]]])
    button(tools, text, `${what}: ${name}`, action).tabIndex = -1;
}

const keyOf = cell => {
  const text = cell.dataset.value ?? cell.textContent.trim();
  const number = /^[-+]?[\d.]+(e[-+]?\d+)?/.exec(text.replace(/\s/g, "").replace(/\u2212/g, "-"));
  return number ? Number(number[0]) : text.toLowerCase();
};
const compare = (a, b) => typeof a === typeof b ? (a < b ? -1 : Number(a > b)) : typeof a === "number" ? -1 : 1;

for (const table of document.querySelectorAll("table.sortable")) {
  const [body] = table.tBodies, heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const text = head.textContent.trim();
    if (!text) return;
    head.textContent = "";
    const made = button(head, text, `Sort by ${text}`, () => {
      const order = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      heads.forEach(other => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", order > 0 ? "ascending" : "descending");
      body.append(...[...body.rows].sort((a, b) => order * compare(keyOf(a.cells[column]), keyOf(b.cells[column]))));
    });
    made.className = "sort";
  });
}

for (const block of document.querySelectorAll("pre.copy")) {
  const made = button(block.parentNode, "Copy", "Copy this text", async () => {
    getSelection().selectAllChildren(block);
    try {
      await navigator.clipboard.writeText(block.textContent);
    } catch {
      document.execCommand("copy");
    }
    made.textContent = "Copied";
    setTimeout(() => { made.textContent = "Copy"; }, 2000);
  });
  made.className = "copy-button";
  block.before(made);
}
