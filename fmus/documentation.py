"""The documentation page of an FMU: the component header's text, its variables, and nothing from the network."""

import re

import jinja2
import latex2mathml.converter
import markdown
from markupsafe import Markup

from fmus.catalog import Component
from fmus.describe import Description, Variable
from fmus.model_description import version

_TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("fmus"),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)
_CODE_OR_MATH = re.compile(r"(?P<code>`[^`]*`)|\$\$(?P<display>.+?)\$\$|\$(?P<inline>.+?)\$", re.DOTALL)
_GROUPS = {
    "Inputs": lambda v: v.causality == "input",
    "Outputs": lambda v: v.causality == "output",
    "Parameters": lambda v: v.causality == "parameter",
    "Internal variables": lambda v: v.causality == "local",
}


def page(component: Component, description: Description) -> str:
    """A complete HTML document."""
    groups = {title: list(filter(belongs, description.variables)) for title, belongs in _GROUPS.items()}
    return _TEMPLATES.get_template("documentation.html").render(
        component=component,
        description=description,
        text=Markup(html(component.text)),
        groups={title: variables for title, variables in groups.items() if variables},
        start=_start,
        version=version(),
    )


def html(text: str) -> str:
    """Markdown with LaTeX between dollar signs as HTML with MathML."""
    formulas: list[str] = []

    def set_aside(match: re.Match[str]) -> str:
        if match["code"]:
            return match[0]
        display = "block" if match["display"] else "inline"
        formulas.append(latex2mathml.converter.convert(match["display"] or match["inline"], display=display))
        return f"\uffff{len(formulas) - 1}\uffff"  # a character no text has, which Markdown leaves alone

    body = markdown.markdown(_CODE_OR_MATH.sub(set_aside, text), extensions=["tables"])
    return re.sub("\uffff(\\d+)\uffff", lambda match: formulas[int(match[1])], body)


def _start(v: Variable) -> str:
    values = v.start_texts
    if not v.shape:
        return "".join(values)
    width = v.shape[-1]
    rows = [", ".join(values[at : at + width]) for at in range(0, len(values), width)]
    return f"[{'; '.join(rows)}]"
