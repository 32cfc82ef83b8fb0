"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ", PER_PAGE = 10;
  const $ = (id) => document.getElementById(id);

  /** An element with attributes and children; a child that is a text is shown as it is. */
  function make(name, attributes = {}, ...children) {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
      if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
      else if (value === true) element.setAttribute(key, "");
      else if (value !== false && value != null) element.setAttribute(key, value);
    }
    element.append(...children.flat().filter((child) => child != null && child !== ""));
    return element;
  }

  // ------------------------------------------------------------ state

  const chosen = new Map(), shown = new Set();
  let page = 0, current = 0, here = [];

  const dimensionOf = (q) => data.tasks[q.task].dimension;
  const varied = (q) => ({ ...q.factors, ...q.nuisances });
  const text = (q) => [q.id, ...q.runs.map((run) => run.text)].join(" ").toLowerCase();
  const haystack = new Map(data.questions.map((q) => [q, text(q)]));
  const unique = (values) => [...new Set(values)];
  const orderly = (values) => unique(values).sort((a, b) => a.localeCompare(b, "en", { numeric: true }));

  function parents(path) {
    const parts = path.split(".");
    return parts.map((_, i) => parts.slice(0, i + 1).join("."));
  }

  /** A fixed order that looks random: by a hash of the question's name. */
  function mixed(id) {
    let hash = 2166136261;
    for (const letter of id) hash = Math.imul(hash ^ letter.codePointAt(0), 16777619);
    hash = Math.imul(hash ^ (hash >>> 15), 2246822519);
    return (hash ^ (hash >>> 13)) >>> 0;
  }

  // ------------------------------------------------------------ filters

  /** Every filter: its label, the values that it offers for some questions, whether a question has a value. */
  const FILTERS = {
    dimension: {
      label: "Dimension",
      values: (qs) => orderly(qs.flatMap((q) => parents(dimensionOf(q)))),
      has: (q, value) => `${dimensionOf(q)}.`.startsWith(`${value}.`),
    },
    task: { label: "Task", values: (qs) => unique(qs.map((q) => q.task)), has: (q, value) => q.task === value },
    factor: {
      label: "Factor",
      values: (qs) => orderly(qs.flatMap((q) => Object.keys(varied(q)))),
      has: (q, value) => value in varied(q),
    },
    value: {
      label: "Value of the factor",
      values: (qs) => { const f = $("factor").value; return f ? orderly(qs.map((q) => varied(q)[f]).filter(Boolean)) : []; },
      has: (q, value) => varied(q)[$("factor").value] === value,
    },
    answer: { label: "Answer", values: (qs) => orderly(qs.map((q) => q.answer)), has: (q, value) => q.answer === value },
    agreement: {
      label: "Engines", values: (qs) => orderly(qs.map((q) => q.agreement)), has: (q, value) => q.agreement === value,
    },
  };
  const NAMES = Object.keys(FILTERS);

  function control(id, label, element) {
    return make("label", { for: id }, label, element);
  }

  function buildFilters() {
    const select = (id, options) => make("select", { id }, options.map(([v, l]) => make("option", { value: v }, l)));
    const engines = [["", "side by side"], ...data.engines.map((e) => [e, e])];
    $("filters").append(
      ...NAMES.map((name) => control(name, FILTERS[name].label, make("select", { id: name }))),
      control("engine", "Shown", select("engine", engines)),
      control("order", "Order", select("order", [["", "as made"], ["mixed", "mixed"]])),
      control("search", "Search", make("input", { id: "search", type: "search", placeholder: "words or an id" })),
    );
    $("filters").addEventListener("input", (event) => {
      if (event.target.id === "engine") return draw();
      if (event.target.id === "factor") $("value").value = "";
      refilter();
    });
    $("filters").addEventListener("submit", (event) => event.preventDefault());
  }

  /** The questions that pass all filters but one. */
  function passing(except) {
    const wanted = NAMES.filter((name) => name !== except && $(name).value);
    const words = $("search").value.toLowerCase().split(/\s+/).filter(Boolean);
    return data.questions.filter((q) =>
      wanted.every((name) => FILTERS[name].has(q, $(name).value)) && words.every((word) => haystack.get(q).includes(word)));
  }

  function refilter() {
    for (const name of NAMES) {
      const kept = $(name).value, values = FILTERS[name].values(passing(name));
      $(name).replaceChildren(make("option", { value: "" }, "all"), ...values.map((v) => make("option", { value: v }, v)));
      $(name).value = values.includes(kept) ? kept : "";
      $(name).disabled = values.length === 0;
    }
    here = passing();
    if ($("order").value) here.sort((a, b) => mixed(a.id) - mixed(b.id));
    page = current = 0;
    draw();
  }

  // ------------------------------------------------------------ a question

  const runsOf = (q) => { const e = $("engine").value; const some = q.runs.filter((run) => run.engine === e); return some.length ? some : q.runs; };
  const open = (q) => q.runs[0].options.length === 0;

  function card(q, place) {
    const told = shown.has(q.id), runs = runsOf(q), heading = `question-${place}`;
    const texts = unique(runs.map((run) => run.text));
    return make("article", { id: `card-${place}`, "aria-labelledby": heading, tabindex: -1, "data-id": q.id,
                             class: place === current ? "current" : "" },
      make("p", { class: "small" }, `${data.tasks[q.task].title} · ${dimensionOf(q)} · ${q.id}`),
      make("h2", { id: heading }, texts.join(" / ")),
      runs.map((run) => runRow(q, run, told)),
      below(q, told), told ? facts(q, runs) : null);
  }

  function runRow(q, run, told) {
    const drawn = run.renderer === run.engine ? null : make("small", {}, `drawn by ${run.renderer}`);
    const looks = run.context.map((look) => make("figure", {},
      make("img", { src: look.src, loading: "lazy", decoding: "async", alt: `${look.camera} camera at ${look.time}, ${run.engine}` }),
      make("figcaption", {}, `${look.camera}, ${look.time}`)));
    const pictures = run.options.some((option) => "src" in option);
    const options = run.options.map((option, i) => choice(q, run, option, i, told));
    return make("div", { class: "run" }, make("div", { class: "engine" }, run.engine, drawn),
      make("div", { class: "looks" }, make("div", { class: "strip" }, looks),
        make("div", { class: pictures ? "strip" : "words", role: "group", "aria-label": `Options, ${run.engine}` }, options)));
  }

  function choice(q, run, option, i, told) {
    const letter = LETTERS[i], true_ = i === run.true, picked = chosen.get(q.id) === i;
    const fate = !told ? null : true_ ? ("src" in option ? "✓ this happens" : "✓ true") : option.change ? `${option.name}: ${option.change.replace("->", "→")}` : "";
    const kind = ["option", "src" in option ? "picture" : "", told && true_ ? "true" : "", picked && !true_ ? "wrong" : ""];
    const label = `Option ${letter}${option.text ? `: ${option.text}` : `, ${run.engine}`}${fate ? `, ${fate}` : ""}`;
    return make("button", { type: "button", class: kind.join(" ").trim(), "aria-label": label, "aria-pressed": String(picked),
                            onclick: () => answer(q, i) },
      "src" in option ? make("img", { src: option.src, loading: "lazy", decoding: "async", alt: "" }) : null,
      make("b", {}, letter), option.text ?? "", fate ? make("span", { class: "fate" }, fate) : null);
  }

  function below(q, told) {
    const picked = chosen.get(q.id), right = picked === q.runs[0].true;
    return make("div", { class: "below" },
      make("button", { type: "button", "aria-expanded": String(told), onclick: () => reveal(q) }, told ? "Hide the truth" : "Show the truth"),
      picked === undefined ? null : make("span", { class: `outcome ${right ? "right" : "wrong"}` },
        right ? `${LETTERS[picked]} is right` : `${LETTERS[picked]} is wrong`));
  }

  /** Everything that would give the answer away. */
  function facts(q, runs) {
    const pairs = (values) => Object.entries(values).map(([name, value]) => `${name} ${value}`).join(" · ");
    const rows = [["Answer", unique(runs.map((run) => run.value)).join(" / ")]];
    if (q.difference) rows.push(["Difference", q.difference]);
    rows.push(["Factors", pairs(q.factors)]);
    if (Object.keys(q.nuisances).length) rows.push(["Nuisances", pairs(q.nuisances)]);
    for (const run of runs) {
      const said = run.measured.map(([name, value]) => `${name} = ${value}`);
      if (run.margin) said.push(`${run.margin} times the margin asked for`);
      if (said.length) rows.push([`Measured, ${run.engine}`, said.join(" · ")]);
    }
    rows.push(["Agreement", agreement(q)]);
    return make("dl", {}, rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
  }

  function agreement(q) {
    const votes = new Map(q.runs.flatMap((run) => run.votes).map(([engine, i, rejected]) => [engine, [i, rejected]]));
    const said = [...votes].map(([engine, [i, rejected]]) =>
      rejected ? `${engine} would not ask it (${rejected})` : i == null ? engine : `${engine} picks ${LETTERS[i]}`);
    return said.length ? `${q.agreement}: ${said.join(", ")}` : q.agreement;
  }

  // ------------------------------------------------------------ doing

  function answer(q, i) {
    if (open(q) || i >= q.runs[0].options.length) return;
    if (!chosen.has(q.id) && !shown.has(q.id)) chosen.set(q.id, i);  // who has seen the truth cannot score
    shown.add(q.id);
    redraw(q);
    score();
  }

  function reveal(q) {
    if (shown.has(q.id)) shown.delete(q.id); else shown.add(q.id);
    redraw(q);
  }

  function redraw(q) {
    const place = here.indexOf(q) - page * PER_PAGE;
    const had = $(`card-${place}`), focused = had.contains(document.activeElement);
    current = place;
    for (const other of $("questions").children) other.classList.remove("current");
    const fresh = card(q, place);
    had.replaceWith(fresh);
    if (focused) fresh.focus({ preventScroll: true });
  }

  function score() {
    const right = data.questions.filter((q) => chosen.get(q.id) === q.runs[0].true && chosen.has(q.id)).length;
    $("score").textContent = chosen.size ? `${right} of ${chosen.size} right` : "";
    $("again").hidden = chosen.size === 0;
  }

  function draw() {
    const pages = Math.max(1, Math.ceil(here.length / PER_PAGE));
    const cards = here.slice(page * PER_PAGE, (page + 1) * PER_PAGE).map(card);
    $("questions").replaceChildren(...(cards.length ? cards : [make("p", { class: "none" }, "No question is like that.")]));
    $("where").textContent = `page ${page + 1} of ${pages}, ${here.length.toLocaleString("en")} questions`;
    $("before").disabled = page === 0;
    $("after").disabled = page >= pages - 1;
  }

  function turn(by) {
    const pages = Math.ceil(here.length / PER_PAGE);
    if (page + by < 0 || page + by >= pages) return false;
    page += by;
    current = 0;
    draw();
    window.scrollTo(0, 0);
    return true;
  }

  function go(by) {
    const last = $("questions").querySelectorAll("article").length - 1;
    if (current + by > last) { if (!turn(1)) return; }
    else if (current + by < 0) { if (!turn(-1)) return; current = $("questions").children.length - 1; }
    else current += by;
    hold();
  }

  /** Mark the current question and keep it in sight. */
  function hold() {
    for (const card of $("questions").children) card.classList.toggle("current", card.id === `card-${current}`);
    $(`card-${current}`)?.focus({ preventScroll: true });
    $(`card-${current}`)?.scrollIntoView({ block: "nearest" });
  }

  function nextEngine() {
    const select = $("engine");
    select.selectedIndex = (select.selectedIndex + 1) % select.options.length;
    draw();
    hold(); // fewer or more pictures make the page shorter or longer
  }

  const KEYS = {
    j: () => go(1), k: () => go(-1), ArrowDown: () => go(1), ArrowUp: () => go(-1), n: () => turn(1), p: () => turn(-1),
    e: nextEngine, "/": () => $("search").focus(), "?": () => $("keys").showModal(),
    r: () => { const q = here[page * PER_PAGE + current]; if (q) reveal(q); },
  };

  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || $("keys").open) return;
    if (event.target.matches("input, select")) { if (event.key === "Escape") event.target.blur(); return; }
    const q = here[page * PER_PAGE + current];
    if (/^[1-9]$/.test(event.key) && q) answer(q, Number(event.key) - 1);
    else if (event.key in KEYS) KEYS[event.key]();
    else return;
    event.preventDefault();
  });

  // ------------------------------------------------------------ beginning

  function theme(name) {
    document.documentElement.dataset.theme = name;
  }

  const tasks = Object.values(data.tasks).length;
  document.title = `${data.name} – wmspec`;
  $("title").textContent = data.name;
  $("about").textContent = `${data.questions.length.toLocaleString("en")} questions of ${tasks} ${tasks === 1 ? "task" : "tasks"}, ` +
    `executed in ${data.engines.join(", ")}. Answer with a click or the keys 1 to 9; the truth is hidden until you do.`;
  document.documentElement.style.setProperty("--shape", data.size.join(" / ")); // so that nothing moves when pictures come
  theme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  $("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
  $("help").addEventListener("click", () => $("keys").showModal());
  $("before").addEventListener("click", () => turn(-1));
  $("after").addEventListener("click", () => turn(1));
  $("again").addEventListener("click", () => { chosen.clear(); shown.clear(); score(); draw(); });
  $("questions").addEventListener("focusin", (event) => {
    const card = event.target.closest("article");
    if (!card || card.id === `card-${current}`) return;
    current = [...$("questions").children].indexOf(card);
    for (const other of $("questions").children) other.classList.toggle("current", other === card);
  });
  buildFilters();
  refilter();
  score();
})();
