"""Groups of possible and impossible episodes: every single picture must be as often possible as not."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.statements.possibility import POSSIBLE
from wmspec.runtime.questions.model import QuestionRow, Rejected

#: Share of pixels below which two pictures show the same.
MIN_DIFFERENT_SHARE = 100 / 256**2
#: Difference of a colour channel (0..255) that counts.
MIN_CHANNEL_DIFFERENCE = 16

_Pixels = NDArray[np.uint8]


def different_share(a: _Pixels, b: _Pixels) -> float:
    """Return the share of pixels in which two pictures (h, w, 3) differ."""
    apart = np.abs(a.astype(np.int16) - b.astype(np.int16)).max(axis=2)
    return float((apart >= MIN_CHANNEL_DIFFERENCE).mean())


def balanced_pictures(
    spec: TaskSpec, members: Mapping[int, Sequence[QuestionRow | Rejected]]
) -> dict[int, Sequence[QuestionRow | Rejected]]:
    """Return the answers of a group by index, without questions of which a single picture tells the answer.

    Without groups, nothing is compared.
    """
    if spec.plan.kind != "groups":
        return {index: list(answers) for index, answers in members.items()}
    rows: dict[tuple[int, str], list[QuestionRow]] = defaultdict(list)
    for answer in (answer for answers in members.values() for answer in answers):
        if isinstance(answer, QuestionRow) and spec.questions[answer.question].asks_possible:
            rows[answer.question, answer.engine].append(answer)
    telling = {key: fault for key, own in rows.items() if (fault := next(_telling_pictures(own), ""))}
    return {index: [_kept(answer, telling) for answer in answers] for index, answers in members.items()}


def _telling_pictures(rows: Sequence[QuestionRow]) -> Iterator[str]:
    """Yield a sentence for every place of which a picture is not as often possible as not."""
    for place in range(min(len(row.context) for row in rows)):
        seen: list[tuple[_Pixels, list[str]]] = []
        for row in rows:
            rgb = row.context[place].rgb
            alike = next((own for own in seen if different_share(own[0], rgb) < MIN_DIFFERENT_SHARE), None)
            if alike is None:
                alike = (rgb, [])
                seen.append(alike)
            alike[1].append(row.value)
        for _, values in seen:
            possible = values.count(POSSIBLE)
            if 2 * possible != len(values):
                of_all = [row.value for row in rows].count(POSSIBLE)
                group = "" if 2 * of_all == len(rows) else f"; of all {len(rows)}, {of_all}"
                yield (
                    f"picture {place + 1} tells the answer: of {len(values)} instances of the group that show it, "
                    f"{possible} are possible{group}"
                )


def _kept(answer: QuestionRow | Rejected, telling: Mapping[tuple[int, str], str]) -> QuestionRow | Rejected:
    if isinstance(answer, Rejected) or (answer.question, answer.engine) not in telling:
        return answer
    detail = telling[answer.question, answer.engine]
    return Rejected(answer.task, answer.index, answer.question, answer.engine, "balance", detail, answer.label)
