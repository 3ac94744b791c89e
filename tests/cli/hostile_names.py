"""Names that act on a terminal, a page, a spreadsheet, a figure or a file system where nobody looks at them."""

NAMES = {
    "clear screen": "a\x1b[2Jb",
    "red": "a\x1b[31mred",
    "link": "a\x1b]8;;file:///x\x1b\\click\x1b]8;;\x1b\\",
    "title": "a\x1b]0;title\x07",
    "NUL": "a\x00b",
    "C1": "a\x9b31mb",
    "back": "good\b\b\b\bbad",
    "return": "good\rbad",
    "DEL": "a\x7fb",
    "lines": "a\nb",
    "tab": "\t=1+1",
    "separator": "a\u2028b\u2029c\x85d",
    "right to left": "a\u202egpj\u2066b",
    "no character": "a\ufffeb\uffff",
    "script": "<script>alert(1)</script><img src=x onerror=alert(1)>",
    "CDATA": "]]><b>&amp;&x;",
    "quotes": 'a"b\'c" onload="d',
    "style": "--><style>*{display:none}</style><!--",
    "template": "{{ 7 * 7 }}{% raw %}%s{0}",
    "markup": "[red]x[/red][link=file:///x]y[/link][/nothing]",
    "formula": '=HYPERLINK("x"&A1,"y")',
    "plus": "+1",
    "minus": "-1+cmd|' /C calc'!A0",
    "at": "@SUM(1)",
    "semicolon": "a;=1+1",
    "apostrophe": "'=1",
    "comment": '# "a" #b',
    "mathematics": r"$\frac{$ $x$",
    "underscore": "_a",
    "above": "../x",
    "emoji": "🔊 mousse",
    "Arabic": "رغوة",
    "long": "n" * 10_000,
}
"""By what they are."""

FILE_NAMES = {what: name for what, name in NAMES.items() if not {"/", "\0"} & {*name} and len(name) < 100} | {
    "surrogate": "a\udc80b"
}
"""Those that a file can have, and bytes that are no text."""
