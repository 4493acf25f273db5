"""What is recorded: derived from the tables."""

from __future__ import annotations

from shared.processes import HEALTHY
from shared.topics import SENSOR_CAMERA, TOPICS, Topic, own_topics


def everything(camera: bool) -> list[Topic]:
    """All topics, and what each service tells of itself.

    Pictures are taken only while somebody wants them, so they may be left out.
    """
    topics = (*TOPICS, *(topic for name in HEALTHY for topic in own_topics(name)))
    return [topic for topic in topics if camera or topic is not SENSOR_CAMERA]
