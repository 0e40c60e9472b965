"""Passive nonlinear observer with wave filter: position and velocity of the vessel without its wave motion."""

from dp_observer.estimate import ObserverEstimate, ObserverInputs, ObserverStatus
from dp_observer.observer import Observer
from dp_observer.settings import ObserverSettings

__all__ = [
    "Observer",
    "ObserverEstimate",
    "ObserverInputs",
    "ObserverSettings",
    "ObserverStatus",
]
