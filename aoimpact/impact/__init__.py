"""The public verbs: an impact of two bodies, a scene of many."""

from .scene import Scene, SceneCase
from .simulate import checked_numbers, plan_impact, simulate

__all__ = [
    "Scene",
    "SceneCase",
    "checked_numbers",
    "plan_impact",
    "simulate",
]
