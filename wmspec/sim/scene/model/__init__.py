"""The input of backends (`Scene`) and their output (`Trace`, `Frame`).

Units are SI, the world is Z up, quaternions are (w, x, y, z), colours are sRGB in 0..1. All values are immutable;
arrays are float64 and never written after construction.
"""

from wmspec.sim.scene.model.actions import (
    Action,
    Follow,
    Force,
    Glide,
    Grip,
    Impulse,
    Launch,
    Paint,
    PassThrough,
    Release,
    Steer,
    Teleport,
    Vanish,
)
from wmspec.sim.scene.model.bodies import Body, Drive, Friction, Geom, Inertia, Joint, JointKind, Mimic, Motion, Surface
from wmspec.sim.scene.model.cameras import Camera, Frame, Light, Observation, Shot
from wmspec.sim.scene.model.episode import Contact, Look, Renderer, Scene, Trace
from wmspec.sim.scene.model.geometry import Array, Pose

__all__ = [
    "Action",
    "Array",
    "Body",
    "Camera",
    "Contact",
    "Drive",
    "Follow",
    "Force",
    "Frame",
    "Friction",
    "Geom",
    "Glide",
    "Grip",
    "Impulse",
    "Inertia",
    "Joint",
    "JointKind",
    "Launch",
    "Light",
    "Look",
    "Mimic",
    "Motion",
    "Observation",
    "Paint",
    "PassThrough",
    "Pose",
    "Release",
    "Renderer",
    "Scene",
    "Shot",
    "Steer",
    "Surface",
    "Teleport",
    "Trace",
    "Vanish",
]
