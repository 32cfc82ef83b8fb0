"""The report as one page that opens anywhere: tables, figures, and how to read them."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files

import pandas as pd

from wmspec.eval.report.figures.style import Drawn
from wmspec.eval.report.frames import DELTA, percent
from wmspec.eval.report.intervals import Estimate
from wmspec.eval.report.items import LEAST_SYSTEMS
from wmspec.eval.report.replies import BASELINES, PEOPLE
from wmspec.eval.report.report import Report
from wmspec.eval.report.tables import CHANCE, Line, Table

#: Tables as a paper prints them: caption and cells by name.
Wide = dict[str, tuple[str, pd.DataFrame]]

#: What each section of the page is called.
TITLES = {
    "results": "Results",
    "compared": "Compared",
    "choices": "How they choose",
    "analyses": "What they see, and what they foresee",
    "items": "The questions",
}


def page(report: Report, figures: dict[str, tuple[Drawn, ...]], wide: Wide) -> str:
    """The page: HTML with its style and figures inside, the same for the same report."""
    style = (files("wmspec.eval.report") / "page.css").read_text(encoding="utf-8")
    title = f"Report{f' on {report.dataset}' if report.dataset else ''}"
    body = [_head(report, title), *(_section(report, name, figures[name], wide) for name in TITLES), _rules(report)]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        f"<main>\n{chr(10).join(filter(None, body))}\n</main>\n</body>\n</html>\n"
    )


def summary(report: Report) -> list[str]:
    """What matters most, in sentences."""
    return [sentence for table in report.tables if (sentence := _summed_up(table))]


def _summed_up(table: Table) -> str:
    models = [line for line in table.lines if line.system not in (PEOPLE, *BASELINES)]
    if not models:
        return f"{table.kind.capitalize()}: only baselines and people have answered."
    best = models[0]
    people = next((line for line in table.lines if line.system == PEOPLE), None)
    text = f"{table.kind.capitalize()}: {best.system} is right most often, {_with_interval(best.average)}"
    text += f"; people are in {percent(people.average.value)} %" if people else ""
    chance = table.chance.average.value
    return text + (f". Guessing yields {percent(chance)} %." if not math.isnan(chance) else ".")


def _with_interval(estimate: Estimate) -> str:
    text = f"in {percent(estimate.value)} %"
    return text + (f" (95 % interval {percent(estimate.low)} to {percent(estimate.high)})" if estimate.sure else "")


def _head(report: Report, title: str) -> str:
    models = sum(system != PEOPLE for system in report.systems)
    replies = sum(a.replies for a in report.accounts)
    about = f"{replies:,} replies of {models} {'model' if models == 1 else 'models'}"
    about += f" and {report.raters} {'person' if report.raters == 1 else 'people'}" if report.raters else ""
    links = " ".join(f'<a href="#{name}">{escape(sentences)}</a>' for name, sentences in TITLES.items())
    sentences = "".join(f"<p>{escape(sentence)}</p>" for sentence in summary(report))
    warned = "".join(f"<p>{escape(sentence)}</p>" for sentence in warnings(report))
    return (
        f'<h1>{escape(title)}</h1>\n<p class="about">{escape(about)}.</p>\n'
        f'<nav>{links} <a href="#rules">Rules</a></nav>\n'
        f'<div class="said">{sentences}</div>' + (f'\n<div class="said warn">{warned}</div>' if warned else "")
    )


def warnings(report: Report) -> list[str]:
    """What a reader must know before believing the numbers."""
    sentences = []
    failed = sum(a.failed for a in report.accounts)
    if failed:
        sentences.append(f"{failed:,} requests never got a reply. They are left out; evaluate again to fill them in.")
    lost = [a for a in report.accounts if a.replies and (a.unparsed + a.refused) / a.replies > 0.05]
    if lost:
        names = ", ".join(f"{a.system} ({(a.unparsed + a.refused) / a.replies:.0%})" for a in lost)
        sentences.append(f"Many replies have no answer in them, and are wrong here: {names}.")
    if report.narrow:
        names = ", ".join(report.narrow[:6]) + (f" and {len(report.narrow) - 6} more" if len(report.narrow) > 6 else "")
        sentences.append(
            f"{names}: these tasks have fewer than five control groups, so their intervals are over instances, and "
            "say nothing of other draws of what was the same in a group."
        )
    if not report.dataset:
        sentences.append(
            "Without --dataset there are no analyses of factors, differences, pairs and counterfactuals, and "
            "questions about what is seen count among the predictions."
        )
    return sentences


# ---------------------------------------------------------------- sections


def _section(report: Report, name: str, figures: Sequence[Drawn], wide: Wide) -> str:
    tables = {"results": _results(report), "items": _items(report)}
    folded = {"choices": ("pairs",), "analyses": ("filtered", "thresholds", "entanglement")}
    parts = [
        *map(_figure, figures),
        *tables.get(name, []),
        *(_folded(n, *wide[n]) for n in folded.get(name, ()) if n in wide),
    ]
    return f'<h2 id="{name}">{TITLES[name]}</h2>\n' + "\n".join(parts) if parts else ""


def _figure(figure: Drawn) -> str:
    data = base64.b64encode(figure.svg.encode()).decode()
    return (
        f'<h3 id="{figure.name}">{escape(figure.title)}</h3>\n<figure><figcaption>{escape(figure.reading)} '
        f'<a class="files" href="figures/{figure.name}.svg">SVG</a></figcaption>'
        f'<img alt="{escape(figure.title)}" src="data:image/svg+xml;base64,{data}"></figure>'
    )


def _results(report: Report) -> list[str]:
    return [*map(_accuracies, report.tables), _accounts(report)]


def _items(report: Report) -> list[str]:
    if report.items is None:
        return [f'<p class="note">Difficulty needs {LEAST_SYSTEMS} models that answered the same questions.</p>']
    suspects = report.items.suspects
    rows = [
        f'<td class="name">{escape(i.id)}</td><td>{escape(i.text)}</td>'
        + _number(f"{i.rest:.2f}")
        + _number(f"{i.accuracy:.0%}")
        for i in suspects
    ]
    few = (
        '<p class="note">Questions that better systems get wrong more often (item-rest correlation). '
        f"With {len(report.items.abilities)} "
        "systems many come about by luck: look at them before you doubt them.</p>"
    )
    table = _table(
        '<tr><th>question</th><th></th><th class="number">item-rest r</th><th class="number">right</th></tr>', rows
    )
    listed = (
        f"<details><summary>{len(suspects)} worst</summary>{table}</details>" if suspects else "<p>There are none.</p>"
    )
    short = sum(n for _, n in report.items.short)
    form = f"<p>A short form of {short} is listed in {_files('short_form')}.</p>" if short else ""
    return [f"{form}<h3>Labels worth a look</h3>{few}{listed}"]


def _folded(name: str, caption: str, frame: pd.DataFrame) -> str:
    """A table for who wants the numbers, folded away."""
    head = "".join(f'<th class="number">{escape(str(c))}</th>' for c in frame.columns)
    rows = [
        f'<td class="name">{escape(str(label))}</td>' + "".join(_number(escape(str(v))) for v in values)
        for label, values in zip(frame.index, frame.to_numpy(), strict=True)
    ]
    summary = f"<summary>{escape(caption.replace(DELTA, 'Δ'))} {_files(name, latex=True)}</summary>"
    return f"<details>{summary}{_table(f'<tr><th></th>{head}</tr>', rows)}</details>"


# ---------------------------------------------------------------- tables


def _accuracies(table: Table) -> str:
    """The paper's table: each cell shaded from chance (white) to all right."""
    groups = [(d, sum(c.dimension == d for c in table.columns)) for d in table.dimensions]
    top = f'<th class="name"></th><th class="group" colspan="{len(groups) + 2}">average</th>'
    top += "".join(f'<th class="group" colspan="{n}">{escape(d)}</th>' for d, n in groups)
    heads = [*map(_upright, ("all", "all, unparsed skipped", *table.dimensions))]
    heads += [_upright(f"{c.letters} {c.task}" if c.environment else c.task) for c in table.columns]
    rows = [_line(table, line) for line in table.lines] + [_line(table, table.chance)]
    return (
        f"<h3>Accuracy in {escape(table.kind)} (%) {_files(table.kind, latex=True)}</h3>\n"
        '<p class="note">Blue is right more often than by guessing, red less often. Averages are as the paper takes '
        "them: the mean over dimensions of the plain mean of their columns. Small: the 95 % interval.</p>"
        + _table(f'<tr>{top}</tr><tr><th class="name"></th>{"".join(heads)}</tr>', rows, opened=True)
    )


def _upright(name: str) -> str:
    return f'<th class="task"><span>{escape(name)}</span></th>'


def _line(table: Table, line: Line) -> str:
    interval = (
        f"<br><small>{percent(line.average.low)}–{percent(line.average.high)}</small>" if line.average.sure else ""
    )
    cells = [f'<td class="number average">{percent(line.average.value)}{interval}</td>']
    cells.append(_number(percent(line.parsed) if line.system != CHANCE else ""))
    chance = table.chance
    cells += [_shaded(line.dimensions.get(d), chance.dimensions.get(d)) for d in table.dimensions]
    cells += [_shaded(line.tasks[c.task], chance.tasks[c.task]) for c in table.columns]
    kind = f' class="{line.system}"' if line.system in (PEOPLE, CHANCE) else ""
    return f'{kind}><td class="name">{escape(line.system)}</td>{"".join(cells)}'


def _shaded(estimate: Estimate | None, chance: Estimate | None) -> str:
    if estimate is None or math.isnan(estimate.value):
        return _number("–")
    guess = 0.0 if chance is None or math.isnan(chance.value) else chance.value
    above = (estimate.value - guess) / (1 - guess) if estimate.value >= guess else (estimate.value - guess) / guess
    tone = "0, 114, 178" if above >= 0 else "213, 94, 0"
    title = (
        f' title="{percent(estimate.low)} to {percent(estimate.high)}, {estimate.questions:,} questions"'
        if estimate.sure
        else ""
    )
    style = f"background: rgba({tone}, {min(1, abs(above)) * 0.45:.2f})"
    return f'<td class="number" style="{style}"{title}>{percent(estimate.value)}</td>'


def _accounts(report: Report) -> str:
    head = ["questions", "replies", "without an answer", "refused", "failed", "tokens in", "tokens out", "cost"]
    rows = []
    for a in sorted(report.accounts, key=lambda a: (*report.systems, a.system).index(a.system)):
        known = (a.questions, a.replies, a.unparsed, a.refused, a.failed, a.tokens_in, a.tokens_out)
        cells = [_number("–" if n is None else f"{n:,}") for n in known]
        cells.append(_number("–" if a.cost is None else f"{a.cost:,.2f}"))
        rows.append(f'<td class="name">{escape(a.system)}</td>' + "".join(cells))
    top = '<tr><th class="name"></th>' + "".join(f'<th class="number">{h}</th>' for h in head) + "</tr>"
    return f"<h3>Replies {_files('replies')}</h3>{_table(top, rows)}"


def _table(head: str, rows: Iterable[str], opened: bool = False) -> str:
    """A table; if `opened`, rows bring the rest of their opening tag."""
    body = "\n".join(f"<tr{row}</tr>" if opened else f"<tr>{row}</tr>" for row in rows)
    return f'<div class="scroll"><table><thead>{head}</thead>\n<tbody>{body}</tbody></table></div>'


def _number(text: str) -> str:
    return f'<td class="number">{text}</td>'


def _files(name: str, latex: bool = False) -> str:
    links = f'<a href="tables/{name}.csv">CSV</a>' + (f' <a href="tables/{name}.tex">LaTeX</a>' if latex else "")
    return f'<span class="files">{links}</span>'


def _rules(report: Report) -> str:
    people = (
        "<p>People's answers to a question count as one: what most of them chose; a tie is decided by a draw that "
        "hangs on the question alone.</p>"
        if report.raters
        else ""
    )
    return (
        '<h2 id="rules">Rules</h2>\n'
        "<p>Several permutations or samples of a question are averaged, so that each question counts once. A reply "
        "without an answer in it, or a refusal, is wrong; the last column of the tables skips them, as the paper "
        "does. A request that never got a reply is left out.</p>\n"
        "<p>Intervals are at 95 %, by bootstrap: control groups are drawn with replacement, 2,000 times, in each "
        "task. Groups are those of the results (instances that share their nuisances), because their questions are not "
        "independent.</p>\n"
        f'{people}<p>Everything on this page is in <a href="report.json">report.json</a>, in <code>tables/</code> and '
        "in <code>figures/</code>.</p>"
    )
