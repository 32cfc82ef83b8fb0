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


#: The column that each task of the catalogue rebuilds, in the paper's order. A new spec adds a line here.
COLUMN_OF_TASK = {
    "relation_tabletop": Column("SR", "ManiSkill", 1600, 2),
    "relation_room": Column("SR", "TDW", 8640, 2),
    "vacancy_tabletop": Column("SE-V", "ManiSkill", 2880, 3),
    "vacancy_room": Column("SE-V", "TDW", 324, 1),
    "occupancy_tabletop": Column("SE-O", "ManiSkill", 1152, 1),
    "occupancy_room": Column("SE-O", "TDW", 941, 1),
    "positioning_tabletop": Column("SP", "ManiSkill", 6400, 2),
    "positioning_room": Column("SP", "TDW", 2000, 2),
    "onset_tabletop": Column("TP", "ManiSkill", 2000, 5),
    "onset_room": Column("TP", "TDW", 5646, 6),
    "duration_tabletop": Column("TE", "ManiSkill", 2000, 5),
    "duration_room": Column("TE", "TDW", 7680, 6),
    "color_tabletop": Column("V-C", "ManiSkill", 648, 3, "which"),
    "color_room": Column("V-C", "TDW", 1440, 3, "which"),
    "shape_room": Column("V-S", "TDW", 1000, 3, "which"),
    "material_room": Column("V-M", "TDW", 1728, 1, "pair"),
    "identification_tabletop": Column("MI", "ManiSkill", 2688, 6),
    "identification_room": Column("MI", "TDW", 1913, 4),
    "speed_tabletop": Column("MS", "ManiSkill", 2304, 4),
    "speed_room": Column("MS", "TDW", 2304, 8),
    "direction_tabletop": Column("MD", "ManiSkill", 2688, 6),
    "direction_room": Column("MD", "TDW", 1913, 6),
    "trajectory_tabletop": Column("MT", "ManiSkill", 6912, 7),
    "trajectory_room": Column("MT", "TDW", 671, 8),
    "count_tabletop": Column("DQ", "ManiSkill", 2520, 1),
    "count_room": Column("DQ", "TDW", 1134, 1),
    "shade_room": Column("CQ", "TDW", 756, 1),
    "majority_tabletop": Column("RQ", "ManiSkill", 2880, 1),
    "majority_room": Column("RQ", "TDW", 1701, 1),
    "slide": Column("M-IP", "Physion slide", 2160, 3),
    "drop": Column("M-IP", "Physion drop", 3456, 3),
    "collide": Column("M-IP", "Physion collide", 1728, 3),
    "drive": Column("M-Nav", "Carla", 1575, 1),
    "walk": Column("M-Nav", "Habitat", 1728, 1),
    "arm_drop": Column("M-Man", "ManiSkill drop", 2304, 1),
    "arm_lift": Column("M-Man", "ManiSkill lift", 2304, 1),
    "arm_push": Column("M-Man", "ManiSkill push", 2304, 1),
    "drive_on": Column("T-Nav", "Carla", 700, 1),
    "walk_on": Column("T-Nav", "Habitat", 1956, 1),
    "arm_push_pick": Column("T-Man", "ManiSkill push and pick", 1728, 1),
    "arm_pick_rotate": Column("T-Man", "ManiSkill pick and rotate", 576, 1),
    "two_balls": Column("C-IP", "TDW", 1296, 3),
    "arms_push": Column("C-Man", "ManiSkill push", 2304, 1),
    "arms_lift": Column("C-Man", "ManiSkill lift", 2304, 1),
}
COLUMNS = tuple(COLUMN_OF_TASK.values())


def instance_count(task: str, questions: int) -> int | None:
    """Return the number of instances with `questions` each that gives the paper's number of cases, or None."""
    found = COLUMN_OF_TASK.get(task)
    return None if found is None else -(-found.cases // questions)
