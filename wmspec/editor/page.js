"use strict";
const at = (id) => document.getElementById(id);
// Every text goes in as text: nothing that a spec says is taken for HTML.
function made(tag, name, ...inside) {
  const node = document.createElement(tag);
  if (name) node.className = name;
  node.append(...inside.filter((part) => part !== ""));
  return node;
}
function cell(it, option) {
  const figure = made("figure", option ? `option${it.true ? " true" : ""}` : "");
  if (it.png) { const img = made("img"); img.src = it.png; img.alt = it.caption; figure.append(img); }
  if (it.text) figure.append(made("b", "", it.text));
  if (it.caption) figure.append(made("figcaption", "", it.true && it.png ? "true" : it.caption));
  return figure;
}
function question(it) {
  const whole = made("div", "question");
  if (it.text) whole.append(made("p", "text", it.text));
  if (it.rejected) whole.append(made("p", "rejected", it.rejected));
  whole.append(made("div", "looks", made("div", "strip", ...it.context.map((c) => cell(c, false))), made("div", "strip", ...it.options.map((c) => cell(c, true)))));
  return whole;
}
function row(it) {
  const head = made("h2", "", `${it.task} ${it.index} `, made("small", "", it.factors));
  return made("article", "", head, ...it.questions.map(question));
}
function show(state) {
  const errors = state.diagnostics.filter((d) => d.severity === "error").length;
  const words = { checking: "checking", drawing: "drawing", done: errors ? `${errors} mistake${errors === 1 ? "" : "s"}` : "no mistakes" };
  at("phase").textContent = words[state.phase];
  at("phase").className = state.phase !== "done" ? "" : errors ? "bad" : "good";
  at("tasks").textContent = state.tasks.map(([name, count]) => `${name}: ${count.toLocaleString("en")} instances`).join(" · ");
  at("diagnostics").replaceChildren(...state.diagnostics.map((d) => made("pre", d.severity, d.text)));
  at("rows").replaceChildren(...state.rows.map(row));
  at("rows").className = state.stale ? "stale" : "";
  document.body.dataset.version = state.version;
}
at("try").onclick = async () => {
  at("try").disabled = true;
  at("trial").hidden = false;
  at("trial").textContent = "trying four instances of each task ...";
  try {
    at("trial").textContent = await (await fetch("trial")).text();
  } catch {
    at("trial").textContent = "wmspec watch has stopped";
  }
  at("try").disabled = false;
};
const events = new EventSource("events");
events.onmessage = (event) => show(JSON.parse(event.data));
events.onerror = () => { at("phase").textContent = "wmspec watch has stopped"; at("phase").className = "bad"; };
