#!/usr/bin/python3
"""Makes a tool's man page and its completions for bash, zsh and fish from its --help.

    make_docs.py BUILD/bin/vol-dwt -o FOLDER

writes FOLDER/man/vol-dwt.1, FOLDER/bash/vol-dwt, FOLDER/zsh/_vol-dwt and FOLDER/fish/vol-dwt.fish. An option is
declared once, in the tool; what it says of itself there is all that these files know.
"""

import argparse
import dataclasses
import pathlib
import re
import subprocess


@dataclasses.dataclass
class Option:
    names: list  # ["-o", "--output"]; of a positional ["input"]
    value: str  # what follows it, as --help prints it: "N in [0 - 4096]", "" for a flag
    required: bool
    default: str
    choices: list
    text: str
    is_file: bool

    @property
    def positional(self):
        return not self.names[0].startswith("-")


@dataclasses.dataclass
class Help:
    name: str
    version: str
    description: list
    groups: list  # of (title, [Option])
    example: list
    remarks: list  # paragraphs after the example


def parse_option(left, text, group):
    words = left.split(" ", 1)
    names, rest = words[0].split(","), words[1] if len(words) > 1 else ""
    relations = re.findall(r"\b(Needs|Excludes): (\S+)", rest)
    rest = re.sub(r"\s*\b(Needs|Excludes): \S+", "", rest)
    text = text.strip()
    if relations:
        text = ". ".join([text.rstrip(".")] + [f"{word} {other}" for word, other in relations]) + "."
    required = bool(re.search(r"\bREQUIRED\b", rest))
    rest = re.sub(r"\s*\bREQUIRED\b", "", rest)
    choices = re.search(r"\{([^}]*)\}", rest)
    default = ""
    bare = rest[: choices.start()] + rest[choices.end():] if choices else rest
    if "=" in bare:
        default = bare.split("=", 1)[1].split(" ")[0]
        rest = rest.replace("=" + default, "", 1)
    value = re.sub(r":\{[^}]*\}", "", rest)
    value = re.sub(r"^(\w+):(INT|UINT|FLOAT|TEXT)\b", r"\1", value).strip()
    value = re.sub(r"^(INT|UINT|FLOAT)\b(:\w+)?", lambda m: "X" if m.group(1) == "FLOAT" else "N", value)
    if names == ["--config"] and not value:
        value = "FILE"
    is_file = group == "Files" or value == "FILE" or not names[0].startswith("-")
    return Option(names, value, required, default, choices.group(1).split(",") if choices else [], text.strip(), is_file)


def parse_help(name, text, version):
    lines = text.splitlines()
    usage = next(i for i, line in enumerate(lines) if line.startswith("Usage:"))
    result = Help(name, version, [line for line in lines[:usage] if line.strip()], [], [], [])
    group, left, words = None, None, []

    def close():
        nonlocal left, words
        if left is not None:
            group[1].append(parse_option(left, " ".join(words), group[0]))
        left, words = None, []

    footer = False
    for line in lines[usage + 1:]:
        if footer:
            if line.startswith("  ") and not result.remarks:
                result.example.append(line.strip())
            elif line.strip():
                result.remarks.append(line.strip())
        elif line == "Example:":
            close()
            footer = True
        elif re.fullmatch(r"\S.*:", line):
            close()
            group = (line[:-1], [])
            result.groups.append(group)
        elif re.match(r"  \S", line) and group:
            close()
            match = re.match(r"  (\S.*?)(?:\s{2,}(.*))?$", line)
            left, words = match.group(1), [match.group(2) or ""]
        elif re.match(r"      \S", line) and left is not None:  # a long list of choices goes on
            left += line.strip()
        elif line.startswith("   ") and left is not None:
            words.append(line.strip())
    close()
    return result


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text[:1] in (".", "'") else text


def man_page(tool):
    title = re.split(r"[:.;](?:\s|$)", " ".join(tool.description))[0]
    out = [f'.TH {tool.name.upper().replace("-", chr(92) + "-")} 1 "" "Precis {tool.version}" "Precis manual"', ".SH NAME",
           f"{roff(tool.name)} \\- {roff(title[0].lower() + title[1:])}", ".SH SYNOPSIS", f".B {roff(tool.name)}"]
    for _, options in tool.groups:
        for option in options:
            if option.required:
                out.append(f".I {roff(option.names[0])}" if option.positional else
                           f".B {roff(option.names[0])}\n.I {roff(option.value.split(' ')[0] or 'VALUE')}")
    out += ["[\\fIoptions\\fR]", ".SH DESCRIPTION"] + [roff(line) for line in tool.description]
    for title, options in tool.groups:
        out.append(f'.SH {roff({"Positionals": "ARGUMENTS", "Files": "FILES", "Run": "RUN OPTIONS"}.get(title, title.upper()))}')
        for option in options:
            names = ", ".join(f"\\fB{roff(n)}\\fR" if n.startswith("-") else f"\\fI{roff(n)}\\fR" for n in option.names)
            value = f" \\fI{roff(option.value)}\\fR" if option.value and not option.positional else ""
            out += [".TP", names + value]
            text = option.text
            if text and text[-1] not in ".:" and (option.choices or option.default):
                text += "."
            if option.choices:
                text += f" One of: {', '.join(option.choices)}."
            if option.default:
                text += f" Default: {option.default}."
            out.append(roff(text or "."))
    if tool.example:
        out += [".SH EXAMPLE", ".nf"] + [roff(line) for line in tool.example] + [".fi"]
    if tool.remarks:
        out.append(".SH NOTES")
        for number, remark in enumerate(tool.remarks):
            out += ([".PP"] if number else []) + [roff(remark)]
    return "\n".join(out) + "\n"


def named_options(tool):
    return [option for _, options in tool.groups for option in options if not option.positional]


def bash_completion(tool):
    function = "_" + tool.name.replace("-", "_")
    names = [name for option in named_options(tool) for name in option.names]
    cases = []
    for option in named_options(tool):
        if not option.value:
            continue
        pattern = "|".join(option.names)
        if option.choices:
            cases.append(f"    {pattern}) COMPREPLY=($(compgen -W '{' '.join(option.choices)}' -- \"$word\")); return ;;")
        elif option.is_file:
            cases.append(f"    {pattern}) COMPREPLY=($(compgen -f -- \"$word\")); return ;;")
        else:
            cases.append(f"    {pattern}) return ;;")
    body = "\n".join(cases)
    return f"""# bash completion of {tool.name}, made from its --help
{function}() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  COMPREPLY=()
  case $before in
{body}
  esac
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W '{' '.join(names)}' -- "$word"))
  else
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}}
complete -o filenames -F {function} {tool.name}
"""


def zsh_completion(tool):
    def quote(text):
        return re.sub(r"[\[\]:']", lambda m: "'\\''" if m.group() == "'" else "\\" + m.group(), text)

    lines = []
    for option in named_options(tool):
        action = ""
        if option.value:
            what = f"({' '.join(option.choices)})" if option.choices else "_files" if option.is_file else " "
            action = f":{quote(option.value.split(' ')[0])}:{what}"
        for name in option.names:
            lines.append(f"  '{name}[{quote(option.text)}]{action}'")
    return f"#compdef {tool.name}\n_arguments \\\n" + " \\\n".join(lines) + " \\\n  '*:file:_files'\n"


def fish_completion(tool):
    lines = []
    for option in named_options(tool):
        words = [f"complete -c {tool.name}"]
        words += [f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.names]
        if option.value:
            words.append("-r" if option.is_file and not option.choices else "-x")
        if option.choices:
            words.append(f"-a '{' '.join(option.choices)}'")
        text = option.text.replace("\\", "\\\\").replace("'", "\\'")
        lines.append(" ".join(words) + f" -d '{text}'")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tool", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()

    def ask(option):
        return subprocess.run([arguments.tool.resolve(), option], check=True, capture_output=True, text=True).stdout

    name = arguments.tool.name
    tool = parse_help(name, ask("--help"), re.search(r"\d+\.\d+\.\d+", ask("--version")).group())
    if not tool.groups or not tool.description:
        parser.error(f"{name} --help has no description or no options in the form this script reads")
    files = {f"man/{name}.1": man_page, f"bash/{name}": bash_completion, f"zsh/_{name}": zsh_completion,
             f"fish/{name}.fish": fish_completion}
    for path, make in files.items():
        target = arguments.output / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(make(tool))


if __name__ == "__main__":
    main()
