"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ", RETRY = 2000;
  const parameters = new URLSearchParams(location.search);
  const words = data.wording.texts, completion = data.wording.completion;

  /** A text of the page, with what stands in braces filled in. */
  const word = (name, values = {}) => words[name].replace(/\{(\w+)\}/g, (_, key) => values[key]);

  /** A text: paragraphs are parted by empty lines, one that begins with # is a heading. Nothing in it is markup. */
  const prose = (text) => text.trim().split(/\n\s*\n/).map((part) =>
    part.startsWith("# ") ? make("h1", {}, part.slice(2)) : make("p", {}, part));

  // ------------------------------------------------------------ what is kept in this browser

  /** The first of these parameters of the link that is there: ours, Prolific's, Mechanical Turk's. */
  const linked = (...names) => (names.map((name) => parameters.get(name)).find(Boolean) ?? "").replace(/[^A-Za-z0-9._-]/g, "").slice(0, 64);
  const rater = linked("rater", "PROLIFIC_PID", "workerId");
  const recruited = { study_id: linked("STUDY_ID", "hitId"), session_id: linked("SESSION_ID", "assignmentId") };
  const KEY = `wmspec-study-${data.study}-${rater}`;
  const random = (bytes) => [...crypto.getRandomValues(new Uint8Array(bytes))].map((b) => b.toString(16).padStart(2, "0")).join("");

  /** The visit: its session, its share (null before consent), answers by step, which of them the server has. */
  let visit = { session: random(16), rater, slot: null, code: null, answers: {}, sent: [] };
  try { visit = { ...visit, ...JSON.parse(localStorage.getItem(KEY) ?? "{}") }; } catch { /* start without answers */ }

  function remember() {
    if (stopped) return;
    try { localStorage.setItem(KEY, JSON.stringify(visit)); } catch { trouble(word("no_storage")); }
  }

  function trouble(text) { $("trouble").textContent = text; }

  // ------------------------------------------------------------ the server, or none

  const pause = (ms) => new Promise((done) => setTimeout(done, ms));

  /** Say something to the server until it is heard; null if it refuses. */
  async function tell(path, body) {
    for (;;) {
      try {
        const reply = await fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
        if (reply.ok) { trouble(""); return await reply.json(); }
        if (reply.status < 500) { trouble(""); return { refused: reply.status }; }
      } catch { /* it is not there, and may come back */ }
      trouble(word("unsent"));
      await pause(RETRY);
    }
  }

  async function begin() {
    if (!data.served) {
      const slot = Number(parameters.get("slot")), count = data.slots.length;
      visit.slot ??= slot >= 1 && slot <= count ? Math.floor(slot) - 1 : crypto.getRandomValues(new Uint32Array(1))[0] % count;
      visit.code ??= random(4).toUpperCase();
      remember();
      return true;
    }
    const place = await tell("visits", { session: visit.session, rater, ...recruited });
    if (place.refused) return false;
    if (visit.slot !== null && visit.slot !== place.slot) visit.answers = {}; // the study's answers were deleted
    Object.assign(visit, { slot: place.slot, sent: place.done, code: place.code });
    remember();
    return true;
  }

  let sending = Promise.resolve(), stopped = false;

  /** Send what the server does not have, one answer after the other. */
  function send() {
    if (!data.served) return sending;
    sending = sending.then(async () => {
      for (const [step, answer] of Object.entries(visit.answers)) {
        if (stopped || visit.sent.includes(Number(step))) continue;
        const place = await tell(`visits/${visit.session}/answers`, answer);
        if (place.refused) { trouble(stopped ? "" : word("refused")); continue; }
        visit.sent = place.done;
        visit.code = place.code;
        remember();
      }
    });
    return sending;
  }

  // ------------------------------------------------------------ showing

  const plan = () => data.slots[visit.slot].map(([item, permutation], step) => ({ step, permutation, ...data.items[item] }));
  const isDone = (step) => step in visit.answers || visit.sent.includes(step);

  /** Show something with one button below it. Returns when the button is pressed, or the form is sent otherwise. */
  function show(children, label, { ready = true, focus = true, aside = null } = {}) {
    return new Promise((done) => {
      const said = make("p", { class: "said", role: "status" });
      const button = make("button", { type: "submit", disabled: !ready }, label);
      const form = make("form", { autocomplete: "off", onsubmit: (event) => { event.preventDefault(); if (!button.disabled) done({ form, button, said }); } },
        children, make("footer", {}, make("div", {}, said, aside, button)));
      $("main").replaceChildren(form);
      window.scrollTo(0, 0);
      if (focus) $("main").focus({ preventScroll: true });
      current = { form, button };
    });
  }

  let current = null;

  /** Play a film once. Returns when it has ended, or cannot be played; the viewer starts it if the browser may not. */
  const played = (film) => new Promise((done) => {
    film.addEventListener("ended", done, { once: true });
    film.addEventListener("error", () => { trouble(word("no_film")); }, { once: true });
    film.addEventListener("canplaythrough", () => { film.play().catch(() => {}); }, { once: true });
    film.load();
  });

  /** The seconds since the pictures were there and the film had ended, and those of them in which the page was not seen. */
  function clock(form) {
    let began = performance.now(), away = 0, left = document.hidden ? began : null;
    const change = () => {
      const now = performance.now();
      if (document.hidden) left ??= now;
      else if (left !== null) { away += now - left; left = null; }
    };
    document.addEventListener("visibilitychange", change);
    const films = [...form.querySelectorAll("video")].map(played), pictures = [...form.querySelectorAll("img")].map((image) => image.decode());
    Promise.allSettled([...pictures, ...films]).then(() => {
      began = performance.now();
      away = 0;
      if (left !== null) left = began;
      form.querySelector("fieldset").disabled = false;
      form.dataset.ready = "";
    });
    return () => {
      change();
      document.removeEventListener("visibilitychange", change);
      const round = (ms) => Math.min(86400, Math.max(0, Math.round(ms) / 1000));
      return { seconds: round(performance.now() - began), away: round(away) };
    };
  }

  function choices(q) {
    const names = q.words.length ? q.words : q.pictures, count = names.length;
    const options = names.map((_, place) => {
      const which = (place + q.permutation) % count, letter = LETTERS[place];
      return make("label", { class: "option", "data-place": which },
        make("input", { type: "radio", name: "answer", value: letter, "aria-label": q.words.length ? `${letter}: ${names[which]}` : word("picture", { number: letter }) }),
        q.pictures.length ? make("img", { src: `pictures/${names[which]}`, alt: "" }) : null,
        make("span", {}, make("b", {}, letter), " ", q.words.length ? names[which] : ""));
    });
    return make("div", { class: `options ${q.pictures.length ? "pictured" : ""}` }, options);
  }

  function number(q) {
    return make("label", { class: "number" }, make("input", { type: "text", name: "answer", inputmode: "decimal", "aria-label": word(q.unit ? "number_in" : "number", { unit: q.unit }),
                                                             pattern: "\\s*-?[0-9]{1,9}([.,][0-9]{1,9})?\\s*", required: true }), q.unit);
  }

  const given = (form) => new FormData(form).get("answer")?.trim().replace(",", ".") ?? "";

  async function ask(q) {
    const looks = q.context.map((name, i) => make("figure", {},
      make("img", { src: `pictures/${name}`, alt: word("picture", { number: i + 1 }) }),
      q.context.length > 1 ? make("figcaption", {}, word("picture", { number: i + 1 })) : null));
    if (q.film) looks.unshift(make("figure", { class: "film" }, make("video", { src: `films/${q.film}`, controls: true, playsinline: true, preload: "auto", "aria-label": word("film") })));
    const kind = q.kind === "practice" ? make("p", { class: "good" }, word("practice")) : null;
    const shown = show([kind, make("h1", { id: "question" }, q.text), looks.length ? make("div", { class: "pictures" }, looks) : null,
      make("fieldset", { "aria-labelledby": "question", disabled: Boolean(q.film) }, make("legend", {}, word(q.open ? "your_answer" : "choose")), q.open ? number(q) : choices(q))],
      word("next"), { ready: false });
    const { form, button } = current, stop = clock(form);
    form.dataset.step = q.step;
    form.addEventListener("input", () => { button.disabled = !given(form) || !form.checkValidity(); });
    const { said } = await shown;
    const answer = { step: q.step, text: given(form), ...stop() };
    if (q.kind === "practice") await feedback(q, answer.text, form, said, button);
    visit.answers[q.step] = answer;
    remember();
    send();
  }

  /** What was right. Returns when the reader goes on. */
  function feedback(q, text, form, said, button) {
    const truth = q.open ? word("about", { number: Number(q.truth[0].toPrecision(3)), unit: q.unit }).trim() : LETTERS[(q.answer - q.permutation + q.options) % q.options];
    const right = q.open ? Math.abs(Number(text) - q.truth[0]) <= q.truth[1] * (1 + 1e-9) : text === truth;
    said.className = `said ${right ? "good" : "bad"}`;
    said.textContent = right ? word("right") : word("truth", { truth });
    for (const option of form.querySelectorAll(".option")) {
      const input = option.querySelector("input");
      option.classList.toggle("true", input.value === truth);
      option.classList.toggle("wrong", input.checked && input.value !== truth);
    }
    for (const input of form.querySelectorAll("input")) input.disabled = true;
    button.textContent = word("go_on");
    button.focus();
    return new Promise((done) => form.addEventListener("submit", done, { once: true }));
  }

  function preload(q) {
    for (const name of q ? [...q.context, ...q.pictures] : []) new Image().src = `pictures/${name}`;
    if (q?.film) make("video", { src: `films/${q.film}`, preload: "auto" });
  }

  // ------------------------------------------------------------ from consent to the end

  async function main() {
    if (visit.slot === null) {
      const decline = make("button", { type: "button", class: "quiet", id: "decline", onclick: () => close("declined") }, word("decline"));
      await show(prose(data.texts.consent), word("agree"), { aside: decline });
      if (!(await begin())) return close("full");
      leaving();
      await show(prose(data.texts.instructions), word("go_on"));
    } else if (await begin()) leaving();
    else return close("full");
    send();
    const steps = plan(), parts = [...new Set(steps.map((q) => q.task).filter(Boolean))];
    let part = "";
    for (const q of steps) {
      q.options = q.words.length || q.pictures.length;
      where(q.step, steps.length);
      if (isDone(q.step)) continue;
      if (q.task && q.task !== part) {
        part = q.task;
        const heading = parts.length > 1 ? make("h1", {}, word("part", { part: parts.indexOf(part) + 1, parts: parts.length })) : null;
        preload(q);
        await show([heading, ...prose(data.texts[`task-${part}`])], word("go_on"));
      }
      preload(steps[q.step + 1]);
      await ask(q);
    }
    where(steps.length, steps.length);
    await end();
  }

  function where(step, count) {
    $("progress").hidden = false;
    $("progress").value = step / count;
    $("where").textContent = step < count ? word("page", { page: step + 1, pages: count }) : word("done");
  }

  /** The page is over without an answer more: the study is full, or the visitor declined or withdrew. */
  function close(name) {
    stopped = true;
    current = null;
    trouble("");
    $("progress").hidden = $("withdraw").hidden = true;
    $("where").textContent = "";
    $("main").replaceChildren(make("h1", {}, word(`${name}_heading`)), make("p", {}, word(name)));
    $("main").focus({ preventScroll: true });
  }

  /** Who began may withdraw at any time: the answers are deleted, here and at the server. */
  function leaving() {
    $("withdraw").hidden = false;
    $("withdraw").onclick = () => { $("leave").returnValue = ""; $("leave").showModal(); };
    $("leave").onclose = async () => {
      if ($("leave").returnValue !== "yes") return $("main").focus({ preventScroll: true }); // Enter goes on again
      stopped = true;
      localStorage.removeItem(KEY);
      if (data.served) await tell(`visits/${visit.session}/withdrawal`, {});
      close("withdrawn");
    };
  }

  /** The code that completes the study, and a link back to the site that invites people, if there is one. */
  const completed = () => [make("p", { class: "code", id: "code" }, completion.code || visit.code),
    completion.url ? make("p", {}, make("a", { id: "return", class: "button", href: completion.url }, word("return"))) : null];

  async function end() {
    const heading = make("h1", {}, word("thanks"));
    if (data.served) {
      $("main").replaceChildren(heading, make("p", {}, word("sending")));
      await send();
      if (!visit.code) return $("main").replaceChildren(heading, make("p", {}, word("not_arrived")));
      $("main").replaceChildren(heading, make("p", {}, word("arrived")), ...completed().filter(Boolean));
      return;
    }
    const file = { study: data.study, session: visit.session, rater, ...recruited, slot: visit.slot, code: visit.code,
                   answers: Object.values(visit.answers).sort((a, b) => a.step - b.step) };
    const url = URL.createObjectURL(new Blob([JSON.stringify(file)], { type: "application/json" }));
    $("main").replaceChildren(heading, make("p", {}, word("save_please")),
      make("p", {}, make("a", { id: "save", class: "button", href: url, download: `answers-${rater || visit.session.slice(0, 8)}.json` }, word("save"))),
      make("p", {}, word("code")), ...completed().filter(Boolean));
  }

  document.addEventListener("keydown", (event) => {
    if ($("leave").open || event.ctrlKey || event.metaKey || event.altKey || !current || event.target.matches("input[type=text]")) return;
    const options = [...current.form.querySelectorAll("input[type=radio]:enabled")];
    const place = /^[1-9]$/.test(event.key) ? Number(event.key) - 1 : event.key.length === 1 ? LETTERS.indexOf(event.key.toUpperCase()) : -1;
    if (options[place]) options[place].click();
    else if (event.key === "Enter" && event.target.tagName !== "BUTTON" && event.target.tagName !== "A" && current.form.isConnected) current.form.requestSubmit();
    else return;
    event.preventDefault();
  });


  for (const element of document.querySelectorAll("[data-word]")) element.textContent = word(element.dataset.word);
  $("progress").ariaLabel = word("progress");
  main();
})();
