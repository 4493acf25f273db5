"""What is recorded: derived from the tables."""

from __future__ import annotations

from shared.processes import HEALTHY
from shared.topics import SENSOR_CAMERA, TOPICS, Topic, health_topic


def everything(camera: bool) -> list[Topic]:
    """All topics and healths; pictures are taken only while somebody wants them, so they may be left out."""
    topics = (*TOPICS, *(health_topic(name) for name in HEALTHY))
    return [topic for topic in topics if camera or topic is not SENSOR_CAMERA]
