"""The contents of WM-ABench, for comparison with the catalogue.

Source: the table of cases in the appendix of *Do Vision-Language Models Have Internal World Models? Towards an Atomic
Evaluation* (Gao et al., 2025), "Benchmark Task Breakdown". Its numbers sum to 104,886.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """One task of the paper: a sub-dimension (in the paper's abbreviation) in one environment.

    `cases` counts its instances, `images` the pictures shown before the options. `question` is the name of the kind of
    question that its chance level belongs to, in tasks of the catalogue that ask several.
    """

    letters: str
    environment: str
    cases: int
    images: int
    question: str = ""

    @property
    def name(self) -> str:
        """Its heading in the paper's tables, such as `MS ManiSkill`."""
        return f"{self.letters} {self.environment}"


COLUMNS = (
    Column("SR", "ManiSkill", 1600, 2),
    Column("SR", "TDW", 8640, 2),
    Column("SE-V", "ManiSkill", 2880, 3),
    Column("SE-V", "TDW", 324, 1),
    Column("SE-O", "ManiSkill", 1152, 1),
    Column("SE-O", "TDW", 941, 1),
    Column("SP", "ManiSkill", 6400, 2),
    Column("SP", "TDW", 2000, 2),
    Column("TP", "ManiSkill", 2000, 5),
    Column("TP", "TDW", 5646, 6),
    Column("TE", "ManiSkill", 2000, 5),
    Column("TE", "TDW", 7680, 6),
    Column("V-C", "ManiSkill", 648, 3, "which"),
    Column("V-C", "TDW", 1440, 3, "which"),
    Column("V-S", "TDW", 1000, 3, "which"),
    Column("V-M", "TDW", 1728, 1, "pair"),
    Column("MI", "ManiSkill", 2688, 6),
    Column("MI", "TDW", 1913, 4),
    Column("MS", "ManiSkill", 2304, 4),
    Column("MS", "TDW", 2304, 8),
    Column("MD", "ManiSkill", 2688, 6),
    Column("MD", "TDW", 1913, 6),
    Column("MT", "ManiSkill", 6912, 7),
    Column("MT", "TDW", 671, 8),
    Column("DQ", "ManiSkill", 2520, 1),
    Column("DQ", "TDW", 1134, 1),
    Column("CQ", "TDW", 756, 1),
    Column("RQ", "ManiSkill", 2880, 1),
    Column("RQ", "TDW", 1701, 1),
    Column("M-IP", "Physion slide", 2160, 3),
    Column("M-IP", "Physion drop", 3456, 3),
    Column("M-IP", "Physion collide", 1728, 3),
    Column("M-Nav", "Carla", 1575, 1),
    Column("M-Nav", "Habitat", 1728, 1),
    Column("M-Man", "ManiSkill drop", 2304, 1),
    Column("M-Man", "ManiSkill lift", 2304, 1),
    Column("M-Man", "ManiSkill push", 2304, 1),
    Column("T-Nav", "Carla", 700, 1),
    Column("T-Nav", "Habitat", 1956, 1),
    Column("T-Man", "ManiSkill push and pick", 1728, 1),
    Column("T-Man", "ManiSkill pick and rotate", 576, 1),
    Column("C-IP", "TDW", 1296, 3),
    Column("C-Man", "ManiSkill push", 2304, 1),
    Column("C-Man", "ManiSkill lift", 2304, 1),
)

#: The column that each task of the catalogue rebuilds. A new spec of the catalogue adds a line here.
COLUMN_OF_TASK = {
    "relation_tabletop": "SR ManiSkill",
    "relation_room": "SR TDW",
    "vacancy_tabletop": "SE-V ManiSkill",
    "vacancy_room": "SE-V TDW",
    "occupancy_tabletop": "SE-O ManiSkill",
    "occupancy_room": "SE-O TDW",
    "positioning_tabletop": "SP ManiSkill",
    "positioning_room": "SP TDW",
    "onset_tabletop": "TP ManiSkill",
    "onset_room": "TP TDW",
    "duration_tabletop": "TE ManiSkill",
    "duration_room": "TE TDW",
    "color_tabletop": "V-C ManiSkill",
    "color_room": "V-C TDW",
    "shape_room": "V-S TDW",
    "material_room": "V-M TDW",
    "identification_tabletop": "MI ManiSkill",
    "identification_room": "MI TDW",
    "speed_tabletop": "MS ManiSkill",
    "speed_room": "MS TDW",
    "direction_tabletop": "MD ManiSkill",
    "direction_room": "MD TDW",
    "trajectory_tabletop": "MT ManiSkill",
    "trajectory_room": "MT TDW",
    "count_tabletop": "DQ ManiSkill",
    "count_room": "DQ TDW",
    "shade_room": "CQ TDW",
    "majority_tabletop": "RQ ManiSkill",
    "majority_room": "RQ TDW",
    "slide": "M-IP Physion slide",
    "drop": "M-IP Physion drop",
    "collide": "M-IP Physion collide",
    "drive": "M-Nav Carla",
    "walk": "M-Nav Habitat",
    "arm_drop": "M-Man ManiSkill drop",
    "arm_lift": "M-Man ManiSkill lift",
    "arm_push": "M-Man ManiSkill push",
    "drive_on": "T-Nav Carla",
    "walk_on": "T-Nav Habitat",
    "arm_push_pick": "T-Man ManiSkill push and pick",
    "arm_pick_rotate": "T-Man ManiSkill pick and rotate",
    "two_balls": "C-IP TDW",
    "arms_push": "C-Man ManiSkill push",
    "arms_lift": "C-Man ManiSkill lift",
}


def column(task: str) -> Column | None:
    """Return the column that a task rebuilds, or None."""
    return next((c for c in COLUMNS if c.name == COLUMN_OF_TASK.get(task)), None)


def instance_count(task: str, questions: int) -> int | None:
    """Return the number of instances with `questions` each that gives the paper's number of cases, or None."""
    found = column(task)
    return None if found is None else -(-found.cases // questions)
