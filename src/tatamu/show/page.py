"""Renders data and a template to one HTML file, which contains the style, scripts, charts and replay.

A template is named by its path in the package, such as "report/page.html", or is a file elsewhere. It extends
"show/base.html", and has the macros of "show/parts.html" as `parts`. Texts are escaped unless they are `Markup`.
"""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Mapping, Sequence
from functools import cache
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from tatamu.base.version import __version__
from tatamu.show import palette
from tatamu.show.chart import Chart, harmless

Charts = Mapping[str, Sequence[Chart]]
"""Groups of charts; those of the group `name` become the elements `name-0`, `name-1`, ... of the page."""


def render(
    template: str | Path, *, charts: Charts | None = None, replay: Mapping[str, Any] | None = None, **values: Any
) -> str:
    """Fill a template with values. The same values always give the same bytes.

    Args:
        template: Path of a template in the package, such as "report/page.html", or a file outside the package.
        charts: Groups of charts, which scripts/charts.js draws into the page.
        replay: Data of `replay.replay_data`, which scripts/replay.js shows; None for no replay.
        **values: Values of the variables in the template.

    Raises:
        jinja2.UndefinedError: If the template uses a variable that has no value.
    """
    plots = {
        f"{name}-{k}": harmless(chart.plot) for name, group in (charts or {}).items() for k, chart in enumerate(group)
    }
    own_script = script("replay_page.js" if replay else "plain_page.js")
    inside = {
        "allowed": Markup(" ".join([_digest(own_script), *([_digest(_plotly_script())] if plots else [])])),
        "charts": charts or {},
        "chart_data": inline(plots) if plots else None,
        "plotly": plotly() if plots else None,
        "replay_data": inline(replay) if replay else None,
        "sides": palette.SIDES[replay["layers"]] if replay else (),
        "has_robot": bool(replay and "robot" in replay),
        "script": own_script,
    }
    environment = _environment()
    if isinstance(template, Path):
        return environment.from_string(template.read_text(encoding="utf-8")).render(**inside, **values)
    return environment.get_template(template).render(**inside, **values)


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("tatamu", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    style = files(__package__).joinpath("style.css").read_text(encoding="utf-8")
    environment.globals.update(
        parts=environment.get_template("show/parts.html").module,
        style=Markup(palette.css() + style),
        version=__version__,
    )
    return environment


def packed(data: bytes) -> str:
    """Compress bytes (deflate) and encode them in base 64; packing.js decodes the result."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


@cache
def plotly() -> str:
    """Return the script of the plotly package, compressed (deflate) and encoded in base 64."""
    return packed(_plotly_script().encode())


@cache
def _plotly_script() -> str:
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs())


@cache
def _digest(text: str) -> str:
    """Return the source that allows exactly this script in a content security policy."""
    return f"'sha256-{base64.b64encode(sha256(text.encode()).digest()).decode()}'"


def inline(value: Any) -> Markup:
    """Return a value as JSON for a script element. No text inside the JSON can close the element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    return Markup(text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029"))


@cache
def script(entry: str) -> Markup:
    """Join an ES module of scripts/ and all modules that it imports to one, in which top-level names must differ."""
    modules: dict[str, str] = {}
    _collect(entry, modules)
    return Markup("\n".join(modules.values()))


def _collect(name: str, modules: dict[str, str]) -> None:
    source = files(__package__).joinpath("scripts", name).read_text(encoding="utf-8")
    for imported in re.findall(r'^import [^;]*? from "\./([\w.]+)";$', source, re.MULTILINE):
        if imported not in modules:
            _collect(imported, modules)
    own = re.sub(r"^import [^;]*;\n+", "", source, flags=re.MULTILINE)
    modules[name] = re.sub(r"^export ", "", own, flags=re.MULTILINE)
