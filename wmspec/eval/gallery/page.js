"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ", PER_PAGE = 10;

  // ------------------------------------------------------------ state

  const KEY = `wmspec-gallery-${data.fingerprint}-${data.name}`;
  const kept = (() => { try { return JSON.parse(localStorage.getItem(KEY) ?? "{}"); } catch { return {}; } })();
  const chosen = new Map(kept.chosen), shown = new Set(kept.shown);
  /** Notes by the question's id: { flag, note }. */
  const notes = new Map(kept.notes);
  let page = 0, current = 0, here = [], range = null;

  /** Keep everything over reloads. Who browses without storage loses it. */
  function remember() {
    const filters = Object.fromEntries([...NAMES, "engine", "model", "order", "search"].map((id) => [id, $(id).value]));
    try { localStorage.setItem(KEY, JSON.stringify({ chosen: [...chosen], shown: [...shown], notes: [...notes], filters, page, range })); } catch { /* as it is */ }
  }

  // ------------------------------------------------------------ what lies beside the page

  const byId = new Map(data.questions.map((q) => [q.id, q])), loading = new Map();
  globalThis.wmspecQuestions = (runs) => { for (const [id, some] of Object.entries(runs)) if (byId.has(id)) byId.get(id).runs = some; };

  /** Load what the page does not have of some questions. */
  const load = (questions) => Promise.all(unique(questions.filter((q) => !q.runs).map((q) => q.file)).map((file) => {
    if (!loading.has(file)) loading.set(file, new Promise((done) => {
      document.head.append(make("script", { src: file, onload: done, onerror: () => { loading.delete(file); done(); } }));
    }));
    return loading.get(file);
  }));
  const trueOf = (q) => q.runs ? q.runs[0].true : q.true;
  const textsOf = (q) => q.texts ?? q.runs.map((run) => run.text);

  const dimensionOf = (q) => data.tasks[q.task].dimension;
  const varied = (q) => ({ ...q.factors, ...q.nuisances });
  function unique(values) { return [...new Set(values)]; }
  const text = (q) => [q.id, ...textsOf(q)].join(" ").toLowerCase();
  const haystack = new Map(data.questions.map((q) => [q, text(q)]));
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
    answered: {
      label: "Models",
      values: (qs) => data.models.length ? ["all right", "some wrong", "all wrong"].filter((v) => qs.some((q) => FILTERS.answered.has(q, v))) : [],
      has: (q, value) => { const a = accuracy(q); return a !== null && (value === "all right" ? a === 1 : value === "all wrong" ? a === 0 : a < 1); },
    },
    noted: {
      label: "Notes", values: () => notes.size ? ["flagged", "with a note"] : [],
      has: (q, value) => { const n = notes.get(q.id); return Boolean(value === "flagged" ? n?.flag : n?.note); },
    },
  };

  /** The share of replies that are right: of the model chosen, else of all. */
  const accuracy = (q) => q.accuracy?.[$("model").value] ?? null;
  /** Of the quantity that differs in most questions; others have no place on its axis. */
  const strength = (q) => q.strength && q.strength.name === quantity() ? q.strength.value : null;
  let known = null;
  function quantity() {
    if (known) return known;
    const counts = new Map();
    for (const q of passing()) if (q.strength) counts.set(q.strength.name, (counts.get(q.strength.name) ?? 0) + 1);
    return known = [...counts].sort((a, b) => b[1] - a[1])[0]?.[0] ?? "";
  }

  /** What questions can be sorted and counted by: a number of each, or null. */
  const MEASURES = {
    margin: { label: "margin", of: (q) => q.margin ?? null },
    difference: { label: "difference", of: strength },
    accuracy: { label: "accuracy", of: accuracy },
  };
  const NAMES = Object.keys(FILTERS);

  function control(id, label, element) {
    return make("label", { for: id }, label, element);
  }

  function buildFilters() {
    const select = (id, options) => make("select", { id }, options.map(([v, l]) => make("option", { value: v }, l)));
    const engines = [["", "side by side"], ...data.runs_of.map((e) => [e, e])];
    $("filters").append(
      ...NAMES.map((name) => control(name, FILTERS[name].label, make("select", { id: name }))),
      control("engine", "Shown", select("engine", engines)),
      control("model", "Accuracy of", select("model", [["", "all"], ...data.models.map((m) => [m, m])])),
      control("order", "Order", select("order", [["", "as made"], ["mixed", "mixed"], ...Object.keys(MEASURES).map((m) => [m, `by ${MEASURES[m].label}`])])),
      control("search", "Search", make("input", { id: "search", type: "search", placeholder: "words or an id" })),
    );
    $("model").parentElement.hidden = !data.models.length;
    $("engine").parentElement.hidden = data.runs_of.length < 2;
    $("filters").addEventListener("input", (event) => {
      if (event.target.id === "engine") return draw();
      if (event.target.id === "factor") $("value").value = "";
      range = null;
      refilter();
    });
    $("filters").addEventListener("submit", (event) => event.preventDefault());
  }

  /** The questions that pass all filters but one. */
  function passing(except) {
    const active = NAMES.filter((name) => name !== except && $(name).value);
    const words = $("search").value.toLowerCase().split(/\s+/).filter(Boolean);
    return data.questions.filter((q) =>
      active.every((name) => FILTERS[name].has(q, $(name).value)) && words.every((word) => haystack.get(q).includes(word)));
  }

  function refilter() {
    for (const name of NAMES) {
      const kept = $(name).value, values = FILTERS[name].values(passing(name));
      $(name).replaceChildren(make("option", { value: "" }, "all"), ...values.map((v) => make("option", { value: v }, v)));
      $(name).value = values.includes(kept) ? kept : "";
      $(name).disabled = values.length === 0;
    }
    known = null;
    here = passing();
    const measure = MEASURES[$("order").value];
    histogram(measure);
    if (measure) here = sorted(here.filter((q) => !range || within(measure.of(q))), measure.of);
    else if ($("order").value) here.sort((a, b) => mixed(a.id) - mixed(b.id));
    page = current = 0;
    draw();
  }

  /** The least first, what has no number last. */
  const sorted = (questions, of) => questions.map((q) => [of(q), q])
    .sort((a, b) => (a[0] === null) - (b[0] === null) || a[0] - b[0]).map(([, q]) => q);
  const within = (value) => value !== null && value >= range[0] && value <= range[1];

  /** How many questions have how much of what they are sorted by; a bar is a filter. */
  function histogram(measure) {
    const values = measure ? here.map(measure.of).filter((v) => v !== null) : [];
    $("histogram").hidden = values.length === 0;
    if (!values.length) return;
    const low = values.reduce((a, b) => Math.min(a, b)), high = values.reduce((a, b) => Math.max(a, b)), count = low === high ? 1 : 16;
    const edge = (i) => i === count ? high : low + (high - low) * i / count;
    const bars = Array.from({ length: count }, () => 0);
    for (const v of values) bars[low === high ? 0 : Math.min(count - 1, Math.floor((v - low) / (high - low) * count))] += 1;
    const most = bars.reduce((a, b) => Math.max(a, b)), said = (v) => Number(v.toPrecision(3));
    const name = measure === MEASURES.difference ? quantity() : measure.label;
    $("histogram").replaceChildren(make("span", {}, `${said(low)}`), ...bars.map((n, i) => {
      const is = range && range[0] === edge(i), label = `${name} ${said(edge(i))} to ${said(edge(i + 1))}: ${n}`;
      const bar = make("button", { type: "button", title: label, "aria-label": label, "aria-pressed": String(Boolean(is)),
                                   onclick: () => { range = is ? null : [edge(i), edge(i + 1)]; refilter(); } });
      bar.style.setProperty("--share", n / most);
      return bar;
    }), make("span", {}, `${said(high)} ${name}`));
  }

  // ------------------------------------------------------------ a question

  const runsOf = (q) => { const e = $("engine").value; const some = q.runs.filter((run) => run.engine === e); return some.length ? some : q.runs; };
  const open = (q) => q.runs[0].options.length === 0;
  const address = (q) => `#${encodeURIComponent(q.id)}`;

  function card(q, place) {
    const revealed = shown.has(q.id), runs = runsOf(q), heading = `question-${place}`;
    const texts = unique(runs.map((run) => run.text));
    return make("article", { id: `card-${place}`, "aria-labelledby": heading, tabindex: -1, "data-id": q.id,
                             class: place === current ? "current" : "" },
      make("p", { class: "small" }, `${data.tasks[q.task].title} · ${dimensionOf(q)} · `,
        make("a", { class: "id", href: address(q), title: "A link to this question" }, q.id)),
      make("h2", { id: heading }, texts.join(" / ")),
      runs.map((run) => runRow(q, run, revealed)),
      below(q, revealed), revealed ? facts(q, runs) : null, revealed ? replies(runs) : null);
  }

  function runRow(q, run, revealed) {
    const drawn = run.renderer === run.engine ? null : make("small", {}, `drawn by ${run.renderer}`);
    const looks = run.context.map((look) => make("figure", {},
      make("button", { type: "button", "aria-label": `Large: ${look.camera} camera at ${look.time}, ${run.engine}`, onclick: () => enlarge(q, look.src) },
        make("img", { src: look.src, loading: "lazy", decoding: "async", alt: `${look.camera} camera at ${look.time}, ${run.engine}` })),
      make("figcaption", {}, `${look.camera}, ${look.time}`)));
    const pictures = run.options.some((option) => "src" in option);
    const options = run.options.map((option, i) => choice(q, run, option, i, revealed));
    return make("div", { class: "run" }, make("div", { class: "engine" }, run.engine, drawn),
      make("div", { class: "looks" }, make("div", { class: "strip" }, film(run, revealed), looks),
        make("div", { class: pictures ? "strip" : "words", role: "group", "aria-label": `Options, ${run.engine}` }, options)));
  }

  /** The film of a run: what is shown; once the truth is known, also what happens. */
  function film(run, revealed) {
    if (!run.film) return null;
    const said = `${run.film.span}${revealed ? ", and what happens" : ""}`;
    return make("figure", { class: "film" },
      make("video", { src: revealed ? run.film.whole : run.film.shown, controls: true, loop: true, playsinline: true, preload: "metadata", "aria-label": `Film: ${said}, ${run.engine}` }),
      make("figcaption", {}, said));
  }

  function choice(q, run, option, i, revealed) {
    const letter = LETTERS[i], true_ = i === run.true, picked = chosen.get(q.id) === i;
    const fate = !revealed ? null : true_ ? ("src" in option ? "✓ this happens" : "✓ true") : option.change ? `${option.name}: ${option.change.replace("->", "→")}` : "";
    const kind = ["option", "src" in option ? "picture" : "", revealed && true_ ? "true" : "", picked && !true_ ? "wrong" : ""];
    const label = `Option ${letter}${option.text ? `: ${option.text}` : `, ${run.engine}`}${fate ? `, ${fate}` : ""}`;
    return make("button", { type: "button", class: kind.join(" ").trim(), "aria-label": label, "aria-pressed": String(picked),
                            onclick: () => answer(q, i) },
      "src" in option ? make("img", { src: option.src, loading: "lazy", decoding: "async", alt: "" }) : null,
      make("b", {}, letter), option.text ?? "", fate ? make("span", { class: "fate" }, fate) : null);
  }

  function below(q, revealed) {
    const picked = chosen.get(q.id), right = picked === q.runs[0].true, { flag = false, note = "" } = notes.get(q.id) ?? {};
    return make("div", { class: "below" },
      make("button", { type: "button", "aria-expanded": String(revealed), onclick: () => reveal(q) }, revealed ? "Hide the truth" : "Show the truth"),
      picked === undefined ? null : make("span", { class: `outcome ${right ? "right" : "wrong"}` },
        right ? `${LETTERS[picked]} is right` : `${LETTERS[picked]} is wrong`),
      pictures(q).length ? make("button", { type: "button", onclick: () => enlarge(q) }, "Large") : null,
      make("button", { type: "button", class: "flag", "aria-pressed": String(flag), onclick: () => mark(q, { flag: !flag }) }, flag ? "⚑ Flagged" : "⚐ Flag"),
      make("details", { class: "note", open: Boolean(note) }, make("summary", {}, "Note"),
        (() => { const area = make("textarea", { "aria-label": `A note on ${q.id}`, maxlength: 4000, oninput: (event) => mark(q, { note: event.target.value }, false) }); area.value = note; return area; })()));
  }

  /** Change a question's flag or note. */
  function mark(q, change, again = true) {
    const { flag, note } = { flag: false, note: "", ...notes.get(q.id), ...change };
    if (flag || note) notes.set(q.id, { flag, note }); else notes.delete(q.id);
    $("export").hidden = notes.size === 0;
    remember();
    if (again) redraw(q);
  }

  /** All flags and notes as a file. */
  function save() {
    const said = { dataset: data.name, fingerprint: data.fingerprint, notes: [...notes].map(([id, said]) => ({ id, ...said })) };
    const url = URL.createObjectURL(new Blob([JSON.stringify(said, null, 1)], { type: "application/json" }));
    make("a", { href: url, download: `${data.name}-notes.json` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
  }

  /** What models and people answered. */
  function replies(runs) {
    const rows = runs.flatMap((run) => (run.replies ?? []).map((reply) => make("tr", {},
      make("td", {}, reply.model), runs.length > 1 ? make("td", {}, run.engine) : null,
      make("td", { class: reply.right ? "right" : "wrong" }, reply.right ? "✓" : "✗", " ", reply.parsed == null ? reply.status === "answered" ? "" : reply.status : LETTERS[reply.parsed]),
      make("td", {}, reply.text))));
    return rows.length ? make("div", { class: "scroll" }, make("table", { class: "replies", "aria-label": "Answers of models and people" }, make("tbody", {}, rows))) : null;
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
      if (run.margin) said.push(`${run.margin} times the required margin`);
      if (said.length) rows.push([`Measured, ${run.engine}`, said.join(" · ")]);
    }
    rows.push(["Agreement", agreement(q)]);
    return make("dl", {}, rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
  }

  function agreement(q) {
    const votes = new Map(q.runs.flatMap((run) => run.votes).map(([engine, ...vote]) => [engine, vote]));
    const apart = (metres) => metres ? `, ${(1000 * metres).toPrecision(2)} mm apart` : "";
    const said = [...votes].map(([engine, [i, rejected, metres]]) =>
      (rejected ? `${engine} would not ask it (${rejected})` : i == null ? engine : `${engine} picks ${LETTERS[i]}`) + apart(metres));
    return said.length ? `${q.agreement}: ${said.join(", ")}` : q.agreement;
  }

  // ------------------------------------------------------------ doing

  function answer(q, i) {
    if (open(q) || i >= q.runs[0].options.length) return;
    if (!chosen.has(q.id) && !shown.has(q.id)) chosen.set(q.id, i);  // who has seen the truth cannot score
    shown.add(q.id);
    redraw(q);
    score();
    remember();
  }

  function reveal(q) {
    if (shown.has(q.id)) shown.delete(q.id); else shown.add(q.id);
    redraw(q);
    remember();
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
    const right = data.questions.filter((q) => chosen.get(q.id) === trueOf(q) && chosen.has(q.id)).length;
    $("score").textContent = chosen.size ? `${right} of ${chosen.size} right` : "";
    $("again").hidden = chosen.size === 0;
  }

  const onPage = () => here.slice(page * PER_PAGE, (page + 1) * PER_PAGE);

  function draw() {
    const questions = onPage(), pages = Math.max(1, Math.ceil(here.length / PER_PAGE));
    const lacking = questions.some((q) => !q.runs);
    if (lacking) load(questions).then(() => { if (onPage().every((q) => q.runs)) { draw(); if (pending) { pending = null; hold(); } } });
    const cards = questions.filter((q) => q.runs).map((q) => card(q, questions.indexOf(q)));
    if (lacking && !cards.length) cards.push(make("p", { class: "none" }, "Loading; if nothing comes, a file is missing beside this page."));
    $("questions").replaceChildren(...(cards.length ? cards : [make("p", { class: "none" }, "No question is like that.")]));
    $("where").textContent = `page ${page + 1} of ${pages}, ${here.length.toLocaleString("en")} questions`;
    $("before").disabled = page === 0;
    $("after").disabled = page >= pages - 1;
    tellRejected();
    remember();
  }

  /** Instances that yield no question, and why. */
  function tellRejected() {
    const task = $("task").value, dimension = $("dimension").value;
    const some = data.rejected.filter(([name]) => (!task || name === task) && (!dimension || FILTERS.dimension.has({ task: name }, dimension)));
    $("rejected").hidden = some.length === 0;
    const reasons = new Map();
    for (const [, , , , reason] of some) reasons.set(reason, (reasons.get(reason) ?? 0) + 1);
    const first = data.rejections > data.rejected.length ? ` of the first ${data.rejected.length.toLocaleString("en")}` : "";
    $("rejected").querySelector("summary").textContent = `Rejected${first}: ${[...reasons].map(([r, n]) => `${n.toLocaleString("en")} ${r}`).join(", ")}`;
    const row = (cell, values) => make("tr", {}, values.map((value) => make(cell, {}, String(value))));
    $("rejected").querySelector("div").replaceChildren(make("table", {}, make("tbody", {}, row("th", ["instance", "engine", "reason", ""]),
      some.slice(0, 200).map(([name, index, question, engine, reason, detail]) => row("td", [`${name}/${index}${question ? `/q${question}` : ""}`, engine, reason, detail])))),
      some.length > 200 ? make("p", { class: "small" }, `and ${(some.length - 200).toLocaleString("en")} more: choose a task`) : "");
  }

  // ------------------------------------------------------------ pictures, large

  /** All pictures of a question as they are shown: what is said of each, where it is, which run and look. */
  function pictures(q) {
    return runsOf(q).flatMap((run) => [
      ...run.context.map((look, i) => ({ src: look.src, said: `${run.engine}: ${look.camera}, ${look.time}`, ways: run.paths ?? [], upTo: i })),
      ...run.options.flatMap((option, i) => "src" in option ? [{ src: option.src, said: `${run.engine}: option ${LETTERS[i]}`, ways: [], upTo: 0 }] : []),
    ]);
  }

  const view = { all: [], images: [], other: false, scale: 1, timer: null };
  const pressed = (id) => $(id).getAttribute("aria-pressed") === "true";

  async function enlarge(q, src) {
    view.all = pictures(q);
    if (!view.all.length) return;
    view.images = view.all.map(({ src }) => Object.assign(new Image(), { src }));
    const first = Math.max(0, view.all.findIndex((picture) => picture.src === src));
    for (const id of ["first", "second"]) $(id).replaceChildren(...view.all.map(({ said }, i) => make("option", { value: i }, said)));
    $("first").value = first;
    $("second").value = Math.min(first + 1, view.all.length - 1);
    view.other = false;
    $("ways").hidden = !view.all.some(({ ways }) => ways.length);
    if (!$("viewer").open) $("viewer").showModal();
    $("canvas").focus();
    await Promise.allSettled(view.images.map((image) => image.decode()));
    const room = $("canvas").parentElement, image = view.images[first];
    const fit = Math.min(room.clientWidth / image.naturalWidth, (innerHeight - 220) / image.naturalHeight);
    view.scale = fit >= 1 ? Math.floor(fit) : 1; // at its own size, or a whole multiple of it
    paint();
  }

  function paint() {
    if (!$("viewer").open) return;
    const places = [Number($("first").value), Number($("second").value)], place = places[view.other ? 1 : 0];
    const image = view.images[place], canvas = $("canvas"), ink = canvas.getContext("2d");
    if (!image?.naturalWidth) return;
    canvas.width = image.naturalWidth;
    canvas.height = image.naturalHeight;
    ink.drawImage(image, 0, 0);
    if (pressed("difference")) subtract(ink, view.images[places[0]], view.images[places[1]]);
    else if (pressed("ways")) drawWays(ink, view.all[place]);
    canvas.style.width = `${canvas.width * view.scale}px`;
    $("scale").textContent = `${view.scale}×`;
    $("caption").textContent = pressed("difference") ? `${view.all[places[0]].said} − ${view.all[places[1]].said}, 4 times as strong` : view.all[place].said;
  }

  /** What differs, four times as strong; done by composition, as pictures on a disk may not be read pixel by pixel. */
  function subtract(ink, a, b) {
    const { width, height } = ink.canvas;
    ink.drawImage(a, 0, 0);
    ink.globalCompositeOperation = "difference";
    ink.drawImage(b, 0, 0, width, height);
    ink.globalCompositeOperation = "lighter";
    for (let times = 1; times < 4; times *= 2) ink.drawImage(ink.canvas, 0, 0);
    ink.globalCompositeOperation = "source-over";
  }

  /** The ways of things up to a picture. */
  function drawWays(ink, { ways, upTo }) {
    ink.lineJoin = "round";
    for (const [color, wide] of [["#141618", 4], ["#fff", 2]]) for (const { points } of ways) {
      const seen = points.slice(0, upTo + 1).filter(Boolean);
      ink.strokeStyle = ink.fillStyle = color;
      ink.lineWidth = wide * ink.canvas.height / 512;
      ink.beginPath();
      seen.forEach(([x, y], i) => i ? ink.lineTo(x + .5, y + .5) : ink.moveTo(x + .5, y + .5));
      ink.stroke();
      for (const [x, y] of seen) { ink.beginPath(); ink.arc(x + .5, y + .5, 1.2 * ink.lineWidth, 0, 7); ink.fill(); }
    }
  }

  function toggle(id) {
    $(id).setAttribute("aria-pressed", String(!pressed(id)));
    clearInterval(view.timer);
    if (pressed("flicker")) view.timer = setInterval(swap, 400);  // slower than three flashes a second (WCAG 2.3.1)
    paint();
  }

  function swap() { view.other = !view.other; paint(); }
  function scale(by) { view.scale = Math.max(.5, Math.min(16, by > 0 ? view.scale * 2 : view.scale / 2)); paint(); }
  function step(by) {
    const count = view.all.length, at = (Number($("first").value) + by + count) % count;
    $("first").value = at;
    $("second").value = (at + 1) % count;
    view.other = false;
    paint();
  }

  const LARGE = { ArrowLeft: () => step(-1), ArrowRight: () => step(1), " ": swap, x: () => toggle("flicker"), d: () => toggle("difference"),
                  w: () => { if (!$("ways").hidden) toggle("ways"); }, "+": () => scale(1), "=": () => scale(1), "-": () => scale(-1) };

  // ------------------------------------------------------------ links to a question

  let pending = null;

  /** Show the question that the address names. */
  function follow() {
    let id = "";
    try { id = decodeURIComponent(location.hash.slice(1)); } catch { return; }
    const q = byId.get(id);
    if (!q) return;
    if (!here.includes(q)) {
      for (const name of [...NAMES, "search"]) $(name).value = "";
      range = null;
      refilter();
    }
    pending = q;
    page = Math.floor(here.indexOf(q) / PER_PAGE);
    current = here.indexOf(q) % PER_PAGE;
    draw();
    hold();
  }

  /** The note on the question at hand. */
  function write(q) {
    const note = $(`card-${here.indexOf(q) - page * PER_PAGE}`)?.querySelector(".note");
    if (note) { note.open = true; note.querySelector("textarea").focus(); }
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

  const at = () => { const q = here[page * PER_PAGE + current]; return q?.runs ? q : undefined; };

  const KEYS = {
    j: () => go(1), k: () => go(-1), ArrowDown: () => go(1), ArrowUp: () => go(-1), n: () => turn(1), p: () => turn(-1),
    e: nextEngine, "/": () => $("search").focus(), "?": () => $("keys").showModal(),
    z: () => { const q = at(); if (q) enlarge(q); }, c: () => { const q = at(); if (q) write(q); },
    f: () => { const q = at(); if (q) mark(q, { flag: !notes.get(q.id)?.flag }); },
    r: () => { const q = at(); if (q) reveal(q); },
  };

  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || $("keys").open) return;
    if ($("viewer").open) {
      if (event.target.matches("select, button") && event.key === " ") return;
      if (event.key in LARGE && !(event.target.matches("select") && event.key.startsWith("Arrow"))) { LARGE[event.key](); event.preventDefault(); }
      return;
    }
    if (event.target.matches("input, select, textarea")) { if (event.key === "Escape") event.target.blur(); return; }
    const q = at();
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
  $("export").addEventListener("click", save);
  $("export").hidden = notes.size === 0;
  for (const [id, does] of Object.entries({ swap, flicker: () => toggle("flicker"), difference: () => toggle("difference"), ways: () => toggle("ways"),
                                            smaller: () => scale(-1), larger: () => scale(1), close: () => $("viewer").close() })) $(id).addEventListener("click", does);
  for (const id of ["first", "second"]) $(id).addEventListener("input", () => { view.other = id === "second"; paint(); });
  $("viewer").addEventListener("close", () => { if (pressed("flicker")) toggle("flicker"); hold(); });
  window.addEventListener("hashchange", follow);
  $("questions").addEventListener("focusin", (event) => {
    const card = event.target.closest("article");
    if (!card || card.id === `card-${current}`) return;
    current = [...$("questions").children].indexOf(card);
    for (const other of $("questions").children) other.classList.toggle("current", other === card);
  });
  buildFilters();
  refilter();
  // What was chosen before: a factor offers its values only when it is chosen.
  for (const [id, value] of Object.entries(kept.filters ?? {})) if (value && $(id)) { $(id).value = value; if (id === "factor") refilter(); }
  range = kept.range ?? null;
  const before = kept.page ?? 0;
  refilter();
  if (before * PER_PAGE < here.length) { page = before; draw(); }
  score();
  follow();
})();
