"""The text of a made-up component's header: what all of them have, around what one is about."""

TEXT = """\
/// # {title}
#pragma once

{includes}

namespace adcs {{

{own}template <class T>
struct {name} {{
    static constexpr auto kind = "{kind}";
    static constexpr auto summary = "{summary}";
    static constexpr auto reference = "";

{body}}};

}}  // namespace adcs
"""


def mock_header(name: str, body: str, summary: str, kind: str = "plant", lifted: bool = False, own: str = "") -> str:
    """`own` stands before the struct, as units do; a law that asks for values of lifted scalars includes `lifted`."""
    includes = ['#include "fmi/declaration.hpp"', *(['#include "fmi/lifted.hpp"'] if lifted else [])]
    return TEXT.format(
        name=name,
        title=summary.capitalize(),
        body=body,
        summary=summary,
        kind=kind,
        includes="\n".join(includes),
        own=own and f"{own}\n",
    )
