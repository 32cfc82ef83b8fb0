"""The option that a reply chooses. Precision goes before recall: a reply that can be taken two ways has none.

In order (`docs/evaluate.md` has examples):

1. the last conclusion counts: "the answer is (B)", "so C", "D is the best match", a boxed or tagged answer. If it names
   two options, or is taken back, the reply has no option;
2. else the option alone on the last line or at the beginning, if they agree: "B. It rolls on.";
3. else the only option that is judged right: "A: wrong. B: matches.";
4. else the only option that is mentioned at all.

A label that is denied, supposed, questioned or in a list never counts.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from . import languages
from .normalize import normalize
from .shown import MARK, ShownOptions, plain

_LIST = re.compile(
    rf"{MARK}(?:\s*(?:,?\s*(?:and|or|nor|und|oder|noch|et|ou|ni|y|o|e|u)\s+(?:also\s+)?|[,、/&+|]\s*(?:and\s|or\s)?"
    rf"|[和与或及とや]|か、?)\s*{MARK})*"
)
#: "A–C", of which the ends stand for all.
_RANGE = re.compile(rf"({MARK})[–—-](?={MARK})")
_SENTENCE_END = re.compile(r"(?<=[.!?;])\s+|(?<=[。!?;])|(?<=が)、|\n+|(?<=⟧)\s*;\s*")
#: Inside a sentence, a conclusion begins a clause of its own.
_CLAUSE = re.compile(
    r"(?i)[,;:.]?\s+(?=(?:so|therefore|thus|hence|consequently|which means|which leaves|that leaves|leaving"
    r"|making it|but|whereas|while|"
    r"however|donc|ainsi|mais|also|daher|deshalb|somit|folglich|aber|sondern|por lo tanto|así que|pero|sino"
    r"|although|though)\b)"
    r"|\s*[,;]?\s*(?==>|->|→|⇒|∴|—|–)|[,、]?(?=因此|所以|故|但|而是|综上|したがって|従って|よって|ゆえに|だから|しかし|つまり)"
)
_FILLER = (
    r"(?:\s*(?:the|option|choice|answer|picture|image|label|letter|candidate|number|that|it|it's|is|be|of|la"
    r"|le|die|das|el|opción|l'option|l'image|probably|likely|most likely|clearly|definitely|therefore|thus|only|simply"
    r"|just|indeed|likely|für|auf|pour|por|~)\b|\s*[,:(\[\"'-]|\s*~)*\s*"
)
_ANSWER_IS = re.compile(
    rf"(?i)(?<![A-Za-z])(?:{languages.ANSWER})(?![A-Za-z])(?:[^⟦⟨.!?\n]{{0,60}}?)(?:{languages.IS}){_FILLER}(?=[⟦⟨])"
)
_CHOOSE = re.compile(rf"(?i)(?<![A-Za-z'])(?:{languages.CHOOSE})(?![A-Za-zÀ-ɏ]){_FILLER}(?=[⟦⟨])")
_SO = re.compile(rf"(?i)(?<![A-Za-zÀ-ɏ'])(?:{languages.SO})(?![A-Za-zÀ-ɏ]){_FILLER}(?=[⟦⟨])")
_POSITIVE = re.compile(rf"(?i)[)\]]?,?:?\s*(?:{languages.POSITIVE})")
_NEGATIVE = re.compile(rf"(?i)[)\]]?:?\s*(?:{languages.NEGATIVE})")
_DENY = re.compile(rf"(?i)(?<![A-Za-zÀ-ɏ])(?:{languages.DENY})(?![A-Za-zÀ-ɏ]){_FILLER}(?:either\s+)?$")
_POSSIBLE = re.compile(
    r"(?i)\s*(?:is|are|seems?|looks?|could|might|may|ist|est|es)(?:\s*(?:also|be|too|both))*\s+(?:possible"
    r"|conceivable|an option|möglich|posible)"
)
_SUPPOSE = re.compile(rf"(?i){languages.SUPPOSE}")
_FORCED = re.compile(
    rf"(?i){languages.FORCED}|(?:between|given the choice between|zwischen|entre) {MARK} (?:and|und|et|y) {MARK},"
)
_UNLESS = re.compile(r"(?i)\b(?:unless|otherwise|es sei denn|à moins|a menos)\b|除非|否则")
_RETRACT = re.compile(rf"(?i){languages.RETRACT}")
_NOUNS = rf"(?:(?:the|final|so|{languages.LABEL_NOUNS})[\s:]*)*"
_HEDGE = re.compile(rf"(?i)(?:{languages.HEDGE})\s*{_NOUNS}$")
_VERDICT = re.compile(
    rf"(?i)[\s(\-•|]*{_NOUNS}({MARK})[^⟦⟨]*?\W(?:(?P<no>incorrect|wrong|no|false|not correct|✗|❌|falsch|faux"
    rf"|incorrecta?)"
    r"|(?P<yes>correct|right|yes|true|✓|✅|richtig|correcte?|correcta))\W*"
)
_CONCLUDED = re.compile(rf"(?i)\s*[)\]]?\s*(?:$|[.,;:!。,、)\-–—(]|(?:{languages.REASON})(?![A-Za-zÀ-ɏ]))")
_LEADING = re.compile(
    rf"(?i)[\s(\-•]*{_NOUNS}({MARK})[)\]]?(?=\s*(?:$|[.,:;!。,)—–=]|-\s|(?:because|since|as|for|denn|weil|car"
    rf"|porque|因为|です|(?<=⟩)\s*of)(?![A-Za-z])))"
)
_ALONE = re.compile(rf"(?i)[\s(\[]*{_NOUNS}({MARK})[\s.)\]!。:]*(?:です。?)?")

#: Characters before and after an option that are searched for words about it.
_REACH = 160
_ENDS, _BEGINS = re.compile(r"\s*[)\]]?\s*[.!。]*\s*$"), re.compile(rf"(?i)^\W*(?:{languages.CONTRAST})?\W*{_NOUNS}$")
#: Maximum length of a reply in which a sole mention counts (characters).
_MAX_MENTION_LENGTH = 2000


@dataclass
class _Evidence:
    """What the clauses of a reply say: conclusions (None if ambiguous), judged, denied and mentioned options.

    An `exposed` one is mentioned at the beginning or the end of a clause.
    """

    conclusions: list[int | None] = field(default_factory=list)
    judged: set[int] = field(default_factory=set)
    denied: set[int] = field(default_factory=set)
    mentioned: set[int] = field(default_factory=set)
    exposed: set[int] = field(default_factory=set)


def choice(text: str, options: Sequence[str | None], labels: str = "letters", whole: bool = True) -> int | None:
    """Return the position of the chosen option, None if there is none.

    `options` are the words of each option as shown, None for a picture; `labels` are "letters", "numbers", or
    "words" if no options were shown. Of a reply that was cut off (not `whole`) only an option at the beginning counts.
    """
    reply, shown = normalize(text), ShownOptions.of(options, labels)
    same = {place for place, words in enumerate(shown.words) if words and words == plain(reply)}
    if len(same) == 1 and not (shown.numbered and plain(reply).isdecimal()):
        return same.pop()
    marked = _RANGE.sub(r"\1, ", shown.mark(reply))
    sentences = [part.strip() for part in _SENTENCE_END.split(marked) if part and part.strip()]
    if not whole:
        return _leading(sentences, shown)
    evidence = _Evidence()
    _read_verdicts(marked, evidence)
    for sentence in sentences:
        _read_sentence(sentence, evidence)
    return _decide(evidence, sentences, marked, shown)


def _decide(evidence: _Evidence, sentences: list[str], marked: str, shown: ShownOptions) -> int | None:
    if evidence.conclusions:
        return evidence.conclusions[-1]
    lines = [line.strip() for line in marked.splitlines() if line.strip()]
    first, last = _leading(sentences, shown), _alone(lines[-1]) if lines else None
    listed = _listed(lines)
    if first in evidence.denied or listed:
        first = None
    if len({place for line in lines if (place := _alone(line)) is not None}) > 1:
        return None
    if first is not None or last is not None:
        return first if last in (None, first) else last if first is None else None
    if listed - evidence.judged - evidence.denied:
        return None
    if len(evidence.judged) == 1 and not evidence.judged & evidence.denied:
        return next(iter(evidence.judged))
    mentioned = evidence.mentioned - evidence.denied
    if evidence.judged or len(mentioned) != 1 or len(marked) > _MAX_MENTION_LENGTH:
        return None
    place = next(iter(mentioned))
    if shown.words[place]:
        # A number may count anything in a longer text.
        return None if shown.words[place].isdecimal() and len(sentences) > 1 else place
    return place if place in evidence.exposed else None


# ---------------------------------------------------------------- clauses


def _read_verdicts(marked: str, evidence: _Evidence) -> None:
    """Read lines that begin with an option and end with a verdict: "(B) the ball is blue. Correct."."""
    found = [match for line in marked.splitlines() if (match := _VERDICT.fullmatch(line.strip()))]
    for match in found if len(found) > 1 else ():
        (evidence.judged if match["yes"] else evidence.denied).add(int(match[1][1:-1]))


def _read_sentence(sentence: str, evidence: _Evidence) -> None:
    if _RETRACT.search(sentence) and evidence.conclusions:
        evidence.conclusions.append(None)
    if sentence.endswith("?"):
        return
    sentence = _FORCED.sub(" ", sentence)
    if _UNLESS.search(sentence) and len(set(re.findall(MARK, sentence))) > 1:
        evidence.conclusions.append(None)
        return
    supposed = False
    for clause in _clauses(sentence):
        concludes = re.match(rf"(?i)\s*[,—–]?\s*(?:{languages.SO})(?![A-Za-z])", clause)
        supposed = bool(_SUPPOSE.search(clause)) or (supposed and not concludes)
        if _SUPPOSE.search(clause) and _conclusion_first(clause) is None:
            continue
        if not supposed or concludes or _conclusion_first(clause) is not None:
            _read_clause(clause, evidence)


def _clauses(sentence: str) -> list[str]:
    return [part for part in _CLAUSE.split(sentence) if part and part.strip()]


def _conclusion_first(clause: str) -> re.Match[str] | None:
    """Return the conclusion of a clause whose condition comes after it: "The answer is B, unless it slips"."""
    found = _ANSWER_IS.search(clause) or _CHOOSE.search(clause)
    condition = _SUPPOSE.search(clause)
    return found if found and condition and found.end() <= condition.start() and found.end() < len(clause) else None


def _read_clause(clause: str, evidence: _Evidence) -> None:
    concluded: list[int | None] = []
    for group in _LIST.finditer(clause):
        mention = _Mention.of(clause, group)
        if mention.is_denied:
            evidence.denied |= mention.hard
        elif mention.is_hedged:
            evidence.mentioned |= mention.places
        elif mention.is_concluded:
            concluded.append(mention.one)
        elif mention.is_judged:
            evidence.judged |= mention.hard if mention.one is not None else set()
        else:
            evidence.mentioned |= mention.hard
            evidence.exposed |= mention.hard if mention.is_exposed else set()
    if concluded:
        evidence.conclusions.append(concluded[0] if len(set(concluded)) == 1 else None)


@dataclass(frozen=True)
class _Mention:
    """An option or a list of options in a clause, with the text before and after it.

    `hard` is empty for words that only count as conclusions; `announced` says whether a phrase such as "the answer is"
    comes directly before.
    """

    places: frozenset[int]
    hard: frozenset[int]
    before: str
    after: str
    announced: bool
    opened: bool

    @classmethod
    def of(cls, clause: str, group: re.Match[str]) -> _Mention:
        places = frozenset(map(int, re.findall(r"\d+", group[0])))
        return cls(
            places,
            frozenset() if "⟨" in group[0] else places,
            clause[max(0, group.start() - _REACH) : group.start()],
            clause[group.end() : group.end() + _REACH],
            _ends_with((_ANSWER_IS, _CHOOSE), clause, group.start()),
            _ends_with((_SO,), clause, group.start()),
        )

    @property
    def one(self) -> int | None:
        """The option, None for several."""
        return next(iter(self.places)) if len(self.places) == 1 else None

    @property
    def is_denied(self) -> bool:
        if _DENY.search(self.before) and not self.announced:
            return True
        return bool(_NEGATIVE.match(self.after)) and not _POSITIVE.match(self.after)

    @property
    def is_hedged(self) -> bool:
        return bool(_HEDGE.search(self.before) or _POSSIBLE.match(self.after))

    @property
    def is_concluded(self) -> bool:
        ends = _CONCLUDED.match(self.after) or _POSITIVE.match(self.after)
        return self.announced or (self.opened and bool(ends))

    @property
    def is_judged(self) -> bool:
        return bool(self.hard and _POSITIVE.match(self.after))

    @property
    def is_exposed(self) -> bool:
        """Whether a sole option begins or ends the clause."""
        return self.one is not None and bool(_ENDS.match(self.after) or _BEGINS.search(self.before))


def _ends_with(patterns: tuple[re.Pattern[str], ...], clause: str, end: int) -> bool:
    begin = max(0, end - _REACH)
    return any(match.end() == end for pattern in patterns for match in pattern.finditer(clause, begin, end + 1))


# ---------------------------------------------------------------- positions in the reply


def _leading(sentences: list[str], shown: ShownOptions) -> int | None:
    """Return the option with which a reply begins."""
    if not sentences:
        return None
    match = _LEADING.match(sentences[0])
    if match is None:
        return None
    group = _LIST.match(sentences[0], match.start(1))
    place = int(match[1][1:-1])
    if group is not None and group.end() > match.end(1):
        return None
    if match[1][0] == "⟨" and _alone(sentences[0]) is None and not _leads_softly(place, sentences[0], shown):
        return None
    return place


def _leads_softly(place: int, sentence: str, shown: ShownOptions) -> bool:
    """Whether a common word or a lower-case letter at the beginning is an answer."""
    return shown.words[place] in languages.LEADING_WORDS or bool(re.match(rf"\s*{MARK}\s*[.:)]", sentence))


def _alone(line: str) -> int | None:
    """Return the option that is all of a line."""
    match = _ALONE.fullmatch(line)
    return int(match[1][1:-1]) if match else None


def _listed(lines: list[str]) -> set[int]:
    """Return the options with which lines or sentences begin, as in a list of them; empty if there is only one."""
    headed = {int(place) for place in re.findall(r"⟦(\d+)⟧\s*[:)]", "\n".join(lines))}
    if len(headed) > 1:
        return headed
    parts = [part for line in lines for part in re.split(r"(?<=[.;])\s+", line) if not part.endswith("?")]
    heads = {int(match[1][1:-1]) for part in parts if (match := _LEADING.match(part)) and match[1][0] == "⟦"}
    return heads if len(heads) > 1 else set()
