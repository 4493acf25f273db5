"""`tandem topic list|echo|hz`: what is said on the bus."""

from __future__ import annotations

import json
import queue
import time
from typing import Annotated, Any

import typer
from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, open_bus, refuse, table, unheard
from services.cli.health.watch import Watch
from shared import topics
from shared.clock import SteadyClock
from shared.topics import topic_by_key
from shared.wire.subscription import Received, Subscription

app = typer.Typer(help="What is said on the bus.")
Key = Annotated[str, typer.Argument(help="Key without the robot, such as wrench/external.")]


@app.command("list")
def list_topics() -> None:
    """Every topic of the contract: key, who publishes it, nominal rate, fields with units."""
    shown = table("key", "publisher", "rate [Hz]", "fields")
    for topic in (*topics.TOPICS, topics.health_topic("<service>")):
        fields = ", ".join(f"{name} [{kind.unit}]" if kind.unit else name for name, kind, _ in topic.message.kinds())
        rate = f"{topic.rate:g}" if topic.rate else "on change"
        shown.add_row(topic.key, topic.publisher, rate, Text(fields))
    Console().print(shown)


@app.command()
def echo(
    key: Key,
    count: Annotated[int, typer.Option(min=0, help="End after this many messages; 0 = go on until Ctrl-C.")] = 0,
    within: Annotated[float, typer.Option(help="Give up when nothing is heard for this long [s].")] = 5.0,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Print the messages of one topic, a JSON object per line."""
    topic = topic_by_key(key)
    if topic is None:
        refuse(f"{key!r} is no topic of the contract; see: tandem topic list")
    heard: queue.SimpleQueue[Received] = queue.SimpleQueue()
    subscription: Subscription = Subscription(topic, SteadyClock(), heard.put)
    printed = 0
    with open_bus(robot, connect) as bus:
        bus.subscribe(topic.key, subscription.offer)
        try:
            while not count or printed < count:
                received = heard.get(timeout=within)
                header = {"seq": received.header.seq, "valid": received.header.valid}
                typer.echo(json.dumps(header | _readable(received.message.to_plain())))
                printed += 1
        except queue.Empty:
            refuse(f"{robot}/{key}: nothing to show for {within:g} s: {unheard(subscription)}", 1)
        except KeyboardInterrupt:
            return


@app.command()
def hz(
    key: Annotated[str, typer.Argument(help="One key; all of them if left out.")] = "",
    seconds: Annotated[float, typer.Option(min=0.5, help="How long to listen [s].")] = 2.0,
    watch: Annotated[bool, typer.Option("--watch", help="Go on until Ctrl-C.")] = False,
    robot: Robot = DEFAULT_ROBOT,
    connect: Connect = DEFAULT_ENDPOINT,
) -> None:
    """Measured rate, age and rejected messages of every topic that is heard."""
    if key and topic_by_key(key) is None:
        refuse(f"{key!r} is no topic of the contract; see: tandem topic list")
    with open_bus(robot, connect) as bus:
        listening = Watch(bus, also=key)
        if watch:
            try:
                with Live(refresh_per_second=4) as live:
                    while True:
                        time.sleep(0.25)
                        live.update(_rates(listening, key) or Text("nothing heard yet"))
            except KeyboardInterrupt:
                return
        time.sleep(seconds)
        rates = _rates(listening, key)
        if rates is None:
            refuse(f"nothing heard on {robot}/{key or '**'} for {seconds:g} s: is a stack running there?", 1)
        Console().print(rates)


def _rates(watch: Watch, only: str) -> Group | None:
    """A row per topic that is heard, and below them what is wrong with what was refused; None if nothing is heard."""
    shown = table("key", "measured [Hz]>", "nominal [Hz]>", "age [ms]>", "rejected>", "publisher")
    now = SteadyClock().now_ns()
    for key, subscription in watch.subscriptions.items():
        if (only and key != only) or (subscription.latest is None and not subscription.rejected):
            continue
        nominal = f"{subscription.topic.rate:g}" if subscription.topic.rate else "on change"
        rejected = subscription.rejected + subscription.out_of_order + subscription.second_session
        shown.add_row(
            key,
            f"{subscription.rate(now):.1f}",
            nominal,
            f"{1e3 * subscription.age(now):.0f}" if subscription.latest else "never",
            str(rejected),
            subscription.topic.publisher,
        )
    wrong = [Text(text, style="red") for key, text in watch.trouble().items() if not only or key == only]
    return Group(shown, *wrong) if shown.row_count else None


def _readable(value: Any) -> Any:
    """Floats to six significant digits; images by their size."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, bytes):
        return f"{len(value)} bytes"
    if isinstance(value, list):
        return [_readable(element) for element in value]
    if isinstance(value, dict):
        return {name: _readable(element) for name, element in value.items()}
    return value
