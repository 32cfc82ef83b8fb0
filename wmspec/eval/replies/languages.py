"""Words by which replies conclude, judge, deny and suppose: English, Chinese, Japanese, German, French, Spanish.

All are fragments of regular expressions, without regard to case.
"""

from __future__ import annotations

import re


def _any(*words: str) -> str:
    return "|".join(words)


#: Words that are options only where an option is expected, since they are frequent in other sentences.
COMMON_WORDS = frozenset({
    "yes", "no", "true", "false", "right", "left", "same", "different", "neither", "both", "none", "equal", "more", "less",
    "up", "down", "first", "second", "third", "fourth", "one", "two", "three", "four", "forward", "forwards", "backward",
    "backwards", "on", "off", "in", "out", "before", "after", "faster", "slower", "it", "long", "short", "front", "back",
})  # fmt: skip
#: Of these, the words that answer when a reply begins with them ("No, they do not").
LEADING_WORDS = frozenset({"yes", "no", "true", "false", "neither", "both", "none", "same", "different", "equal"})

LABEL_NOUNS = _any(
    "options?", "choices?", "answers?", "candidates?", "pictures?", "images?", "figures?", "panels?", "numbers?",
    "letters?", "item", "alternatives?", "opción", "opcion", "imagen", "respuesta", "letra", "réponse", "proposition",
    "lettre", "antwort", "bild", "auswahl", "möglichkeit", "buchstabe", "选项", "選択肢", "图", "画像", "図", "選択", "项",
)  # fmt: skip
#: Nouns whose letter is the name of an object in a scene, not of an option.
NAMED_OBJECTS = _any(
    "ball", "object", "cube", "block", "sphere", "car", "box", "point", "robot", "person", "body", "cone", "cylinder",
    "vitamin", "position", "corner", "plan", "zone", "area", "room", "door", "team", "grade", "type", "ramp", "wall",
)  # fmt: skip
ORDINAL_NOUNS = _any(
    "option", "choice", "answer", "candidate", "picture", "image", "one", "alternative", "opción", "imagen", "réponse",
    "proposition", "antwort", "bild", "möglichkeit", "选项", "个选项", "个", "项", "幅图", "張", "张", "の選択肢", "の画像",
    "の図", "です", "目",
)  # fmt: skip
#: Ordinals and their positions from 0, -1 for the last.
ORDINAL_WORDS: tuple[tuple[str, int], ...] = (
    (_any("first", "1st", "erste[nrs]?", "première", "primera", "第一", "1番目", "一番目"), 0),
    (_any("second", "2nd", "zweite[nrs]?", "deuxième", "seconde", "segunda", "第二", "2番目", "二番目"), 1),
    (_any("third", "3rd", "dritte[nrs]?", "troisième", "tercera", "第三", "3番目", "三番目"), 2),
    (_any("fourth", "4th", "vierte[nrs]?", "quatrième", "cuarta", "第四", "4番目", "四番目"), 3),
    (_any("fifth", "5th", "fünfte[nrs]?", "cinquième", "quinta", "第五", "5番目"), 4),
    (_any("sixth", "6th"), 5),
    (_any("seventh", "7th"), 6),
    (_any("eighth", "8th"), 7),
    (_any("last", "letzte[nrs]?", "dernière", "última", "最后一", "最後"), -1),
)
#: Pictures of the question by number: no options where options have letters.
NUMBERED_PICTURE = re.compile(
    r"(?i)\b(?:the\s+)?(?:(?:picture|image|frame|photo|bild|imagen|figure)s?\s*#?\s*\d+(?:\s*(?:,|and|to|-|und|et"
    r"|y|bis)\s*\d+)*"
    r"|(?:first|second|third|fourth|fifth|sixth|last|final|1st|2nd|3rd|4th)\s+(?:pictures?|images?|frames?"
    r"|photos?))(?!\w)"
    r"|(?:图片?|画像|図|写真)\s*\d+|第[一二三四五六\d]+(?:张|幅|枚目?)(?:图片?|の?画像|の?図)?"
)

_QUALIFIERS = _any("final", "correct", "right", "best", "most likely", "only", "my", "clear", "likely", "obvious")
#: Nouns of an answer; a verb or a colon must follow.
ANSWER = _any(
    rf"(?:(?:{_QUALIFIERS})\s+)*(?:answer|choice|option|pick|selection|guess|solution|response|prediction|verdict"
    r"|conclusion|candidate|outcome|picture|image|match|one|alternative|total|sum|count|result)",
    r"(?:endgültige |richtige |korrekte |finale |beste )*(?:antwort|lösung|option|wahl|ergebnis|bild|möglichkeit)",
    r"(?:bonne |meilleure )?(?:réponse|option|image|solution|proposition|choix)(?: finale| correcte| exacte)*",
    r"(?:opción|respuesta|imagen|solución|alternativa|elección)(?: final| correcta| adecuada| más probable)*",
    r"(?:最终|正确|最佳|最合适|我)?的?(?:答案|选项|选择|结论)(?:应该|应当|应)?",
    r"(?:最終的な|正しい|最も適切な|適切な|私の)?(?:答え|正解|解答|回答|選択肢|結論)",
)  # fmt: skip
IS = _any(
    r"(?:\s*(?:(?:is|was|be|would|should|must|has|have|to|will|therefore|thus|then|clearly|likely|definitely|hence"
    r"|most|probably|here|simply|indeed|actually|still|then|also|therefore|lautet|ist|wäre|daher|somit|also|est"
    r"|serait"
    r"|donc|sera|es|sería|por lo tanto|entonces|debe ser|claramente|clairement|eindeutig)\b|:|=|->|=>|→|⇒|-|–|—))+",
    r"\s*(?:应该|应当|应)?(?:是|为|選|选|:|=|就是)+", r"\s*(?:は|が|:|=)+、?",
)  # fmt: skip
#: Verbs of choosing, directly before an option.
CHOOSE = _any(
    r"(?:i|we)(?:'d| would|'ll| will| should| must|'m going to| have to|'m| am)?\s*(?:therefore |thus |hence |so "
    r"|now |still "
    r"|finally )?(?:choos(?:e|ing)|pick(?:ing)?|select(?:ing)?|go(?:ing)? (?:with|for)|opt(?:ing)? for"
    r"|settle (?:on|for)|vote"
    r" for|bet on|say|guess|answer(?: with)?|conclude(?: that)?(?: it(?:'s| is| must be))?)",
    r"(?:i|we) (?:chose|picked|selected"
    r"|went with)", r"(?:going|sticking|stick|go) with", r"choose", r"select", r"pick",
    r"(?:i|we) (?:think|believe|am confident|would say|'d say)(?: that)?(?: (?:it|this|the answer) ?(?:'s|is"
    r"|must be))?",
    r"(?:my|the) vote goes to", r"points? (?:clearly )?to", r"corresponds? (?:best )?to", r"(?:match(?:es)? )?what(?:'s| is) shown in", r"narrows? (?:it )?down to", r"answer with", r"lock(?:ing)? in",
    r"ich (?:wähle|nehme|würde|tippe auf|entscheide mich für|antworte|sage)(?: daher| also)?(?: mit)?", r"wähle ich",
    r"nehme ich", r"entscheide ich mich für",
    r"je (?:choisis|dirais|prends|retiens|sélectionne|réponds|vote pour|penche pour)(?: donc)?",
    r"(?:elijo|escojo|selecciono|elegiría|diría|me quedo con|voto por|respondo|yo diría)",
    r"(?:我)?(?:应该|应当|应|会|就|只能|最终|因此|所以|故|还是)?(?:选择?|选取|选定|挑选)",
)  # fmt: skip
#: Words that open a clause against the one before.
CONTRAST = _any(
    "but", "however", "whereas", "while", "although", "aber", "jedoch", "mais", "pero", "但", "而", "しかし"
)
#: Words that open a conclusion; the option must follow at once and end its clause or be judged.
SO = _any(
    "so", "therefore", "thus", "hence", "consequently", "accordingly", "in conclusion", "to conclude", "by elimination", "by exclusion", "par élimination", "por eliminación", "por descarte",
    "nach dem ausschlussverfahren", "in the end", "correct", "probably", "most likely", "likely", "all (?:options |of them )?but", "everything but",
    "sondern", "mais", "sino", "but rather", "not [⟦⟨]\\d[⟧⟩],? but", "overall",
    "ultimately", "in summary", "in short", "that leaves(?: us with| only)?", "leaving(?: us with| only)?", "which leaves(?: only)?",
    "this leaves(?: us with"
    "| only)?", "leaves(?: us with| only)?", "we are left with", "i'm left with", "it(?: has to| must|'s got to) be",
    "it must therefore be", "it's", "it is", "that's", "that is", "that makes it", "making it", "this is", "this means",
    "which means", "that means", "final", "conclusion", "result", "verdict", "=>", "->", "→", "⇒", "∴", "definitely", "clearly", "here", "best match",
    "closest match", "also", "daher", "deshalb", "somit", "folglich", "demnach", "deswegen", "damit", "bleibt(?: nur)?", "es ist", "das ist",
    "donc", "ainsi", "par conséquent", "en conclusion", "c'est(?: donc)?", "il reste", "reste", "por lo tanto", "por tanto", "así que",
    "entonces", "en conclusión", "en consecuencia", "luego", "queda", "es", "因此", "所以", "故", "综上(?:所述)?", "总之", "应该是", "应为",
    "就是", "是", "可见", "于是", "したがって", "従って", "よって", "ゆえに", "だから", "つまり", "結論として", "以上より", "結論",
)  # fmt: skip
#: A judgement after an option: "B is the right one".
POSITIVE = _any(
    r"(?:\s*(?:is|are|seems|looks|appears|must be|has to be|would be|remains|to be|shows|being|as|therefore"
    r"|clearly|thus|the|a|an"
    r"|only|most|more|best|one|option|by far|to me|also|definitely)\b)*\s*(?:right(?![\s-]+(?:of|side|half|edge|hand))"
    r"|correct|best|answer|true"
    r"|match(?:es)?|fits?|likely|plausible"
    r"|consistent|accurate|valid|closest|comes closest|agrees?|corresponds?|winner|my (?:final )?(?:answer|choice"
    r"|pick)|works|remains|the one|it(?=\s*(?:[.,;:!)]|$))|✓|✔|✅|☑)(?![\w])"
    r"(?!\s+(?:only|except|but)\b)",
    r"(?:\s*(?:ist|scheint|wäre|also|die|das|am|daher|somit|zeigt|eindeutig)\b)*\s*(?:richtig(?:e)?|korrekt|passt"
    r"|stimmt|zutreffend|wahrscheinlichsten|beste)(?!\w)",
    r"(?:\s*(?:est|semble|serait|la|le|donc|bien|plus)\b)*\s*(?:correcte?|exacte?|bonne?(?: réponse)?|juste"
    r"|plausible|probable|convient|correspond|vraie?|meilleure?)(?!\w)",
    r"(?:\s*(?:es|parece|sería|la|más|que)\b)*\s*(?:correct[oa]|adecuad[oa]|coincide|encaja|verdader[oa]"
    r"|corresponde|mejor)(?!\w)",
    r"(?:项|选项|图|才|最|是|完全|的)*(?:正确|符合|对的|匹配|吻合|合适|一致)",
    r"(?:です|を選び(?:ます)?|を選択(?:します)?|が正しい|が正解|が最も(?:適切|近い|合)|が一致|が合って|だけが(?:合|一致|正し)|である|だと(?:思|考)|に(?:なり|決定)|が適切"
    r"|と(?:答え|考え|思い))",
)  # fmt: skip
#: A denial after an option or a list of options.
NEGATIVE = _any(
    r"(?:\s*(?:is|are|was|were|also|both|clearly|all|can|could|do|does|did|would|has|have|be|being|therefore"
    r"|definitely|the|seem|seems|looks?"
    r"|obviously|almost|probably|simply|just|option|a|shows?|depicts?|that|which|should|may|must)\b)*\s*(?:not\b"
    r"|n't\b|no longer|isn't|aren't|can't|cannot|couldn't|doesn't|don't|won't|wouldn't|didn't|shouldn't"
    r"|wrong|incorrect|false|out\b|too\b|impossible|implausible|unlikely|inconsistent|mirrored|eliminated|excluded"
    r"|ruled out|invalid|fails?|contradicts?|violates?|mismatch(?:es)?"
    r"|less likely|neither|incompatible|rejected|inaccurate|mislead(?:s|ing)|tempting|the opposite|off\b|never"
    r"|lacks?|misses|only (?:half|part)|no\b|dismissed|discarded|rejected|ignored|skipped|corrupted|missing"
    r"|disregarded|✗|✘|❌|×)",
    r"(?:\s*(?:ist|sind|kann|können|wäre|zeigt|zeigen|passt|passen|scheidet|scheiden|fällt|fallen|kommt|kommen"
    r"|beide|auch|also|hingegen|das|die|den)\b)*\s*(?:nicht|falsch|kein\w*|aus\b|weg\b|unmöglich|zu (?:hoch|weit"
    r"|früh))",
    r"(?:\s*(?:est|sont|ne|n'est|n'a|peut|sont|être|montre|correspond|convient|va|colle|serait|se|le|la|l'|aussi"
    r"|à)\s*)*\s*(?:pas\b|fauss?e?s?\b|incorrecte?s?|impossible|éliminée?s?|exclue?s?|à exclure|trop\b|ne\b|n')",
    r"(?:\s*(?:es|son|está|están|muestra|también|que|la|se|puede|pueden|queda|quedan)\b)*\s*(?:no\b"
    r"|incorrect[oa]s?|fals[oa]s?|imposibles?|descarta\w*|demasiado)",
    r"(?:项|选项|图|都|显然|也|可以|被|中|里|、)*(?:不|错|排除|有误|没有|不符|无法)",
    r"(?:[はもがを]|、)*(?:すべて|全て|両方|明らかに)?(?:間違|誤|違い|違う|不正解|除外|不適切|合いません|合わない|一致しません|一致しない|ではな|ではあ|じゃな|でな|高すぎ|消去)",
)  # fmt: skip
#: A denial before an option or a list of options.
DENY = _any(
    r"(?:not|isn't|aren't|cannot be|can't be|couldn't be|rather than|instead of|unlike|except(?: for)?|exclud\w+"
    r"|rul(?:e|es|ed|ing) out|(?<!by )eliminat\w+|reject\w*|discard\w*"
    r"|dismiss\w*|neither|nor|never|drop|cross(?:ed)? out|it won't be|other than|confus\w+ with|not the|(?:more"
    r"|fewer|less|greater|later|earlier) than|at least|at most|tempted by|tempted to (?:say|choose|pick)"
    r"|first thought(?: of| it was)?|cannot choose|can't choose|do not choose|don't pick|wouldn't (?:choose|pick)"
    r"|would not (?:choose|pick)|don't think it's|do not think it is|unlikely to be)",
    r"(?:nicht|kein\w*|statt|anstatt|außer|weder|noch|ausgeschlossen(?: sind)?|schließe(?: ich)?|gegen)",
    r"(?:pas|ni|plutôt que|au lieu de|sauf|exclu\w*|élimin\w*|j'exclus|j'élimine|écarte\w*)",
    r"(?:no|no es|ni|en lugar de|en vez de|excepto|salvo|descarto|(?<!by )elimino|descart\w+|(?<!by )elimin\w+"
    r"|excluy\w+)",
    r"(?:不是|不选|并非|排除了?|而不是|除了|不会是|不应选|不能选)", r"(?:除外|ではなく)",
)  # fmt: skip
#: Doubt directly before an option, which is then no conclusion.
HEDGE = _any(
    "could be", "might be", "may be", "can be", "maybe", "perhaps", "either", "könnte", "vielleicht", "entweder", "peut-être",
    "pourrait être", "soit", "quizás", "podría ser", "tal vez", "可能是?", "也许是?", "或许是?",
)  # fmt: skip
#: A condition: what depends on it is supposed, not concluded.
SUPPOSE = _any(
    r"\b(?:if|unless|suppos(?:e|ing)|assuming|had (?:it|the|we)|were (?:it|the)|in case|whether|would (?:only|need"
    r"|have|require|imply|mean|show)|could also be|might (?:suggest|think|say))\b",
    r"\b(?:wenn|falls|angenommen|sofern|ob)\b", r"\b(?:si|s'il|supposons)\b", r"\b(?:supongamos|fuera|si)\b",
    r"(?:如果|假如|假设|若|要是|除非)", r"(?:もし|仮に|ならば|場合は|とすれば|れば)",
)  # fmt: skip
#: A polite condition, which introduces a choice.
FORCED = _any(
    r"\bif (?:i|we) (?:had|have|must|were forced|was forced|need)(?: to)? (?:choose|guess|pick|answer|decide"
    r"|say)(?: (?:one|an option|something))?,?",
    r"\bif forced(?: to (?:choose|guess"
    r"|pick))?,?", r"\bif (?:i|we) (?:consider|look at|compare|follow) [^,⟦⟨]{0,60},",
    r"\bwenn ich (?:raten|wählen) (?:muss"
    r"|müsste),?", r"\bsi je (?:dois|devais) choisir,?", r"\bsi (?:tengo|tuviera) que elegir,?",
)  # fmt: skip
#: A change of mind: what was concluded before no longer counts.
RETRACT = (
    r"^\W*(?:(?:oh|hmm|but|hm)[ ,.]*)*(?:wait|actually|on second thoughts?|correction|scratch that|no wait"
    r"|let me re\w+|moment|warte|attendez|espera|等等|等一下|不对|待って|いや)\b"
    r"|\b(?:i was wrong|i made a mistake|my mistake|that's wrong|that was wrong|let me (?:re-?check|reconsider"
    r"|look again))\b|等等|不对,"
)
#: Reasons and ends after an option that was concluded.
REASON = (
    r"because|since|as|for|due|given|where|with|which|by|denn|weil|da|mit|car|parce|puisque|porque|ya|pues|因为"
    r"|由于|ので|から|です|だ|を|吧|了|项|选项|at|in this|on balance|here|alone|then|too|now|again|instead|after all|in (?:this"
    r"|the) picture|and not|and|not|rather|nicht|pas|than|than|over"
)
