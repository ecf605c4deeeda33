#!/usr/bin/env python3
"""Writes docs/results/<name>.md from run folders, and the README's table from the first of them.

    python3 scripts/results_table.py runs/quickstart [runs/fsr-glove28 ...] [--readme] [--partial] [--check]
    python3 scripts/results_table.py --configs

A page has the name of its run folder: the same config with other values (--set, --output) is another page. It does not
hold the config. It links the file under configs/, names the settings that the run changed, and states the SHA-256 of
config.toml in the run folder, which holds the whole. File and settings are found by asking the program
(target/release/taxel, or TAXEL=/path/to/taxel) which of them give that config.
--configs checks all pages: file and settings must still give the config of that digest. After a change of a config or
of a default they do not, and the page then shows an earlier experiment.
With each page goes docs/results/reference/<name>.json: scores and costs of every row, digests of data and config.
--check compares a run with that file, row by row, and writes nothing. --partial makes a page of a run that is not
finished, and says what is missing.

Needs Python 3 and taxel. Every number comes from the run folder: scores and costs from results.json, latency
from timings.jsonl, what hardening changes from the tables of `taxel report`, provenance from environment.json, a
twin's accuracies from twin.jsonl where
scripts/twin/train.py wrote one, else from the page before. Published numbers keep their own column.
"""

import argparse
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"
TAXEL = os.environ.get("TAXEL", ROOT / "target" / "release" / "taxel")
# Samples that `taxel report` asks under faults, where --max-samples does not say otherwise.
UNDER_FAULTS = 1000


def tables(page):
    """The tables of a page, each as (heading above it, head, rows by their first cell)."""
    found, heading, head = [], "", None
    for line in (RESULTS / f"{page}.md").read_text().splitlines():
        if line.startswith("## "):
            heading = line[3:]
        if not line.startswith("| ") and not line.startswith("|-"):
            head = None
            continue
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if head is None:
            head = cells
            found.append((heading, head, {}))
        elif not set(line) <= set("|-: "):
            found[-1][2][cells[0].strip("`")] = cells
    return found


def spread(scores, sd, key):
    if not scores:
        return "not run"
    return f"{scores[key]:.2f} ± {sd[key]:.2f}" if sd else f"{scores[key]:.2f}"


def latency(folder, network):
    for line in (folder / "timings.jsonl").read_text().splitlines():
        entry = json.loads(line)
        if entry.get("network") == network and "latency_p50_ms" in entry:
            return f"{entry['latency_p50_ms']:.3f}"
    return "–"


TWIN = "PyTorch twin, same folds %"


def twins(folder):
    """Accuracy of each network's PyTorch twin; where the run has none, those that the page had: the folds are the same."""
    path = folder / "twin.jsonl"
    if path.exists():
        return {line["network"]: line["twin"] for line in map(json.loads, path.read_text().splitlines())}
    name = folder.resolve().name
    before = tables(name) if (RESULTS / f"{name}.md").exists() else []
    return {network: float(cells[head.index(TWIN)])
            for _, head, rows in before if TWIN in head
            for network, cells in rows.items() if cells[head.index(TWIN)] != "–"}


def stress(folder):
    """What `taxel report` found under faults, or None."""
    path = folder / "judgement.json"
    return json.loads(path.read_text()).get("stress") if path.exists() else None


def lost(folder):
    """Mean loss under faults by network, where the report has tested them."""
    return {n["network"]: n["mean_loss"] for n in (stress(folder) or {}).get("networks", [])}


def markdown(head, rows):
    """A table whose first column is text and whose others are numbers."""
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines)


def table(folder, results, only=None, short=False):
    """All networks of a run, or those named, in their order; a short one has accuracy and F1 beside the published accuracy."""
    networks = results["networks"]
    if only is not None:
        known = {n["network"]: n for n in networks}
        networks = [known[name] for name in only]
    twin, losses = twins(folder), lost(folder)
    published = any(n.get("published") for n in networks)
    head = ["network", "parameters", "MACs", f"accuracy % [{results['source']}]", "macro-F1 %", "latency ms"]
    # A paper that prints all four has them compared.
    full = not short and any("precision" in (n.get("published") or {}) for n in networks)
    timed = not short and any("seconds" in (n.get("published") or {}) for n in networks)
    sizes = not short and any("megabytes" in (n.get("published") or {}) for n in networks)
    head[4:4] = ["macro precision %", "macro recall %"] if full else []
    head += ["lost under faults, pp"] if losses else []
    head += [TWIN] if twin else []
    which = "accuracy / precision / recall / F1, " if full else ""
    head += [f"*published*: {which}the paper's own data %"] if published else []
    head += ["*published*: MB, GFLOPs"] if sizes else []
    head += ["training s", "*published*: training s, their machine"] if timed else []
    rows = []
    for n in networks:
        if (n.get("hardening") or {}).get("unmet"):
            continue
        row = [f"`{n['network']}`", f"{n['costs']['parameters']:,}", f"{n['costs']['macs']:,}"]
        scores = ["accuracy", "precision", "recall", "f1"] if full else ["accuracy", "f1"]
        row += [*(spread(n["mean"], n["sd"], key) for key in scores), latency(folder, n["network"])]
        if losses:
            row.append(f"{losses[n['network']]:.1f}" if n["network"] in losses else "–")
        if twin:
            row.append(f"{twin[n['network']]:.2f}" if n["network"] in twin else "–")
        if published:
            own = n.get("published")
            # [mean, SD], or [mean] where no spread is published.
            printed = [" ± ".join(f"{score:.2f}" for score in own[key]) for key in (scores if full else ["accuracy"]) if own.get(key)] if own else []
            row.append("*" + " / ".join(printed) + "*" if printed else "–")
        if sizes:
            own = n.get("published") or {}
            row.append(f"*{own['megabytes']:g}, {own['gflops']:g}*" if "megabytes" in own else "–")
        if timed:
            own = n.get("published") or {}
            row += [training(folder, n["network"]), f"*{own['seconds']:g}*" if "seconds" in own else "–"]
        rows.append(row)
    return markdown(head, rows)


def views(folder, results):
    """The tables that the config names, each under its title, and what stands in none of them."""
    named = tomllib.loads((folder / "config.toml").read_text()).get("tables", [])
    if not named:
        return table(folder, results)
    shown = {name for view in named for name in view["networks"]}
    rest = [n["network"] for n in results["networks"] if n["network"] not in shown]
    parts = [(view["title"], view["networks"]) for view in named] + ([("Beside them", rest)] if rest else [])
    return "\n\n".join(f"## {title}\n\n{table(folder, results, names)}" for title, names in parts)


def chosen(folder, results):
    """What the folds chose by their validation parts, and how often."""
    lines = []
    for n in results["networks"]:
        records = [json.loads(path.read_text()) for path in sorted(folder.glob(f"folds/{n['network']}.r*.f*.json"))
                   if not path.name.endswith(".timing.json")]
        sets = [record["chosen"]["set"] for record in records if record.get("chosen")]
        words = [", ".join(f"{key} = {value:g}" for key, value in own.items()) for own in sets]
        if words:
            counts = ", ".join(f"{word} ({words.count(word)} of {len(words)})" for word in sorted(set(words)))
            lines.append(f"- `{n['network']}`: {counts}")
    return "\n\nChosen by the validation part:\n\n" + "\n".join(lines) if lines else ""


def changes(results):
    """How far training moved the convolutions from their start, in thirds of the network."""
    rows = []
    for n in results["networks"]:
        own = [change["change"] for change in n.get("changes", [])]
        if any(own):
            third = -(-len(own) // 3)
            parts = [own[start:start + third] for start in range(0, len(own), third)]
            most = max(n["changes"], key=lambda change: change["change"])
            cells = [f"{sum(own) / len(own):.2e}", *(f"{sum(part) / len(part):.2e}" for part in parts)]
            rows.append(f"| `{n['network']}` | " + " | ".join(cells) + f" | `{most['layer']}` {most['change']:.2e} |")
    if not rows:
        return ""
    head = "| network | mean of all | first third | second | last | most |\n| --- | ---: | ---: | ---: | ---: | --- |\n"
    words = ("How far training moved the convolutions from where they started: mean squared difference of both kernels "
             "scaled to 0..1, mean over folds, frozen ones 0 (Rouhafzay et al. 2021, Figs. 3 and 4; all layers are in `results.json`).")
    return f"\n\n{words}\n\n{head}" + "\n".join(rows)


def other_statistics(results):
    """What the choice of batch-norm statistics does to the same weights."""
    lines = []
    for kind in ("moving", "population"):
        own = [n for n in results["networks"] if n.get("other_statistics", {}).get("batch_norm") == kind]
        score = lambda n: n["other_statistics"].get("score", n["other_statistics"].get("accuracy"))
        words = [f"`{n['network']}` {score(n):.2f} ({score(n) - n['mean']['accuracy']:+.2f})" for n in own]
        says = f"\n\nAccuracy % of the same weights with *{kind}* batch-norm statistics:"
        # A sentence holds a few networks, a list any number.
        if len(words) > 4:
            lines.append(f"{says}\n\n" + "\n".join(f"- {word}" for word in words))
        elif words:
            lines.append(f"{says} " + ", ".join(words) + ".")
    return "".join(lines)


def attributes(results):
    """Of several attributes each by itself, and every level of it, as Table 2 of Zhang et al. 2022 has them."""
    parts = []
    for at, attribute in enumerate(results.get("attributes", [])):
        own = {n["network"]: n["attributes"][at] for n in results["networks"] if n["mean"]}
        levels = attribute["classes"]
        head = ["network", "accuracy %", "macro-F1 %", "off by, levels", *(level.removeprefix(f"{attribute['name']}-") for level in levels)]
        rows = []
        for name, scores in own.items():
            each = [" / ".join(f"{100 * level[key]:.0f}" for key in ("precision", "recall", "f1")) for level in scores["per_level"]]
            rows.append([f"`{name}`", f"{100 * scores['accuracy']:.2f}", f"{100 * scores['f1']:.2f}", f"{scores['mean_absolute_error']:.2f}", *each])
        parts.append(f"\n\n## {attribute['name']}\n\nEvery level: precision / recall / F1, %.\n\n{markdown(head, rows)}")
    return "".join(parts)


def shortcut(results):
    found = results.get("shortcut")
    if not found:
        return ""
    return (f"\n\n**Confounded?** {len(found['statistics'])} global statistics of a sample alone tell "
            f"{100 * found['accuracy']:.1f} % of the samples (chance {100 * found['chance']:.1f} %): part of every score may be "
            f"the recording, not touch. They are {', '.join(found['statistics'])}.")


def hardening(folder):
    """The report's tables of what training under faults changes, where there are some."""
    found = [folder / "tables" / f"{name}.md" for name in ("hardening", "unmet-faults")]
    return "".join(f"\n\n{path.read_text().strip()}" for path in found if path.exists())


def commit(environment):
    """Nine digits of the commit, and whether files had changed since."""
    known = environment.get("commit", "unknown")
    return known[:9] + ("-dirty" if known.endswith("-dirty") else "")


def processor(environment):
    """The processor with the width of its vectors, where the run has written it."""
    return environment["cpu"] + (f" ({environment['vectors']})" if environment.get("vectors") else "")


def words(protocol):
    """The protocol as the program's own table says it."""
    split = {"stratified": "stratified", "group": "grouped"}[protocol["split"]]
    kind = {
        "k-fold": lambda: f"{split} {protocol['folds']}-fold",
        "random-splits": lambda: f"{split} random splits, {100 * protocol['test']:.0f} % test",
        "few-samples": lambda: f"few samples per class, {split} random {100 * protocol['test']:.0f} % test",
        "leave-group-out": lambda: "leave one group out",
        "official": lambda: "the data set's own split",
    }[protocol["kind"]]()
    times = protocol["repetitions"]
    return kind + (f", {times} repetitions" if times > 1 else "")


def training(folder, network):
    """Mean seconds of a training."""
    timings = [json.loads(path.read_text()) for path in folder.glob(f"folds/{network}.r*.f*.timing.json")]
    seconds = [own["train_seconds"] for own in timings]
    return f"{sum(seconds) / len(seconds):.3g}" if seconds else "–"


def missing(results):
    """What an unfinished run lacks."""
    if results["complete"]:
        return ""
    most = max(len(n["folds"]) for n in results["networks"])
    rows = [f"`{n['network']}` {len(n['folds'])}" for n in results["networks"] if len(n["folds"]) < most]
    return (f"**Not the whole run:** {len(results['missing'])} trainings are still to be made"
            + (f"; folds so far: {', '.join(rows)}, all others {most}" if rows else f"; every row has {most} folds so far") + ".\n\n")


def reference(folder):
    """What a later run of the same config has to give again."""
    results = json.loads((folder / "results.json").read_text())
    environment = json.loads((folder / "environment.json").read_text())
    rows = {n["network"]: {"folds": len(n["folds"]), **n["costs"], **{key: [n["mean"][key], (n["sd"] or {}).get(key)] for key in n["mean"]}}
            for n in results["networks"] if n["mean"]}
    config = hashlib.sha256((folder / "config.toml").read_bytes()).hexdigest()
    return {"name": folder.resolve().name, "source": results["source"], "commit": commit(environment), "config_sha256": config,
            "data_digest": results["data_digest"], "vectors": environment.get("vectors"), "rows": rows}


def lines(reference):
    """A reference as JSON, with a row on a line."""
    rows = ",\n".join(f"  {json.dumps(name)}: {json.dumps(row)}" for name, row in reference["rows"].items())
    head = "".join(f" {json.dumps(key)}: {json.dumps(own)},\n" for key, own in reference.items() if key != "rows")
    return f'{{\n{head} "rows": {{\n{rows}\n }}\n}}\n'


def differences(own, before):
    """In what two references differ; empty where scores are equal to the last digit of the page."""
    said = [f"{key}: {own[key]}, was {before[key]}" for key in ("data_digest", "config_sha256") if own[key] != before[key]]
    # Metrics and costs that only one of the two versions of taxel writes.
    one_sided = set()
    for name in sorted({*own["rows"], *before["rows"]}):
        new, old = own["rows"].get(name), before["rows"].get(name)
        if not (new and old):
            said.append(f"{name}: only in {'this run' if new else 'the reference'}")
            continue
        one_sided |= {(key, "this run" if key in new else "the reference") for key in {*new} ^ {*old}}
        for key in (key for key in new if key in old):
            a, b = ([round(value, 2) for value in each if value is not None] if isinstance(each, list) else each for each in (new[key], old[key]))
            said += [f"{name} {key}: {a}, was {b}"] if a != b else []
    said += [f"{key}: only in {where}; the two are of different versions of taxel, and a page that is written anew compares it"
             for key, where in sorted(one_sided)]
    if said and own["vectors"] != before.get("vectors"):
        said.append(f"computed with {own['vectors']}, the reference with {before.get('vectors') or 'vectors of unknown width'}: "
                    "matrix products are rounded elsewhere then, so that trainings end a little elsewhere")
    return said


def printed(config, sets):
    """The whole config of a file with some values set, as the program prints it; None if it refuses them."""
    command = [TAXEL, "run", config, "--print-config", *(word for own in sets for word in ("--set", own))]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    return done.stdout if done.returncode == 0 else None


def inline(value):
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {inline(own)}" for key, own in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def settings(want, have, prefix=""):
    """What --set has to say for `have` to become `want`, by dotted keys."""
    said = []
    for key in want:
        if isinstance(want[key], dict) and isinstance(have.get(key), dict):
            said += settings(want[key], have[key], f"{prefix}{key}.")
        elif want[key] != have.get(key):
            said.append(f"{prefix}{key}={inline(want[key])}")
    return said


def bare(config):
    """A config without the words about it, which change no result."""
    return {key: own for key, own in tomllib.loads(config).items() if key not in ("title", "expect")}


def short(config, key):
    """The networks or baselines of a resolved config, each with what it has beside the settings for all of them."""
    rows = []
    for row in config[key]:
        row = {part: own for part, own in row.items() if part != "label" or own != row["name"]}
        if "train" in row:
            row["train"] = changed(row["train"], config["train"])
        rows.append({part: own for part, own in row.items() if own != {}})
    return rows


def changed(want, have):
    """The entries of a table that another does not have."""
    tables = {key: changed(own, have[key]) for key, own in want.items()
              if isinstance(own, dict) and isinstance(have.get(key), dict) and own.get("name") == have[key].get("name")}
    return {key: tables.get(key, own) for key, own in want.items() if own != have.get(key)}


def named(config):
    """The same with rows as a config file has them."""
    return {**config, **{key: short(config, key) for key in ("networks", "baselines") if key in config}}


def origin(config):
    """The file under configs/ that a resolved config was made from, and the settings that it takes; None if there is none.

    That is the file of its name. Where the name was set too, it is the one that takes the fewest settings.
    """
    want = bare(config)
    found = []
    for path in sorted((ROOT / "configs").rglob("*.toml")):
        path = path.relative_to(ROOT)
        whole = printed(path, [])
        if whole is None:
            continue
        sets = settings(named(want), named(bare(whole)))
        is_named = bare(whole)["name"] == want["name"]
        if is_named or not found or len(sets) < len(found[0][2]):
            if bare(printed(path, sets) or whole) == want:
                found = [(is_named, path, sets)]
        if is_named and found and found[0][0]:
            break
    return found[0][1:] if found else None


def commands(name, config, made, asked=None):
    """How to make a page again: `taxel run`, `taxel report` where faults are on it, and this script."""
    out = "" if name == bare(config)["name"] else f" --output runs/{name}"
    if made:
        path, sets = made
        lines = ["taxel run " + shlex.join([str(path), *(word for own in sets for word in ("--set", own))]) + out]
    else:
        lines = [f"taxel run {name}.toml{out}  # a config that is not kept here"]
    if asked is not None:
        lines.append(f"taxel report runs/{name}" + (f" --max-samples {asked}" if asked > UNDER_FAULTS else ""))
    lines.append(f"python3 scripts/results_table.py runs/{name}")
    return "Made again by:\n\n```sh\n" + "\n".join(lines) + "\n```"


def config_line(config, made):
    """Which config a page is of: its file, the settings that the run changed, its digest."""
    digest = hashlib.sha256(config.encode()).hexdigest()
    if not made:
        return f"Config: not kept here; SHA-256 of the whole `{digest}`."
    path, sets = made
    words = ", ".join(f"`{own}`" for own in sets) or "nothing"
    return f"Config: [{path}](../../{path}); changed: {words}; SHA-256 of the whole `{digest}`."


def remarks_line(name):
    """A link to what was written by hand about a page; its file names the page in its second paragraph."""
    for path in sorted((RESULTS / "remarks").glob("*.md")):
        if f"](../{name}.md)" in path.read_text().split("\n\n")[1]:
            return f"Remarks: [{path.stem}](remarks/{path.name})."
    return ""


def check_configs():
    """1 if the config of a page is no longer the one that its digest is of, else 0."""
    found = False
    for path in sorted(RESULTS.glob("*.md")):
        text = path.read_text()
        if not text.startswith(f"# {path.stem}\n\nGenerated by `scripts/results_table.py`."):
            continue
        if "\nConfig: not kept here; " in text:
            continue
        digest = re.search(r"^Config: .*; SHA-256 of the whole `(\w+)`\.$", text, re.M)
        command = re.search(r"^taxel run (.*)$", text, re.M)
        if not (digest and command):
            print(f"{path.stem}: names no config")
            found = True
            continue
        config, *words = shlex.split(command[1], comments=True)
        whole = printed(config, [own for flag, own in zip(words, words[1:]) if flag == "--set"])
        if whole is None or hashlib.sha256(whole.encode()).hexdigest() != digest[1]:
            print(f"{path.stem}: {config} " + ("is refused" if whole is None else "gives another config by now"))
            found = True
    return int(found)


def page(folder, partial=False):
    results = json.loads((folder / "results.json").read_text())
    environment = json.loads((folder / "environment.json").read_text())
    if not (results["complete"] or partial):
        raise SystemExit(f"{folder}: not complete; finish it with --resume, or show what there is with --partial")
    protocol = results["protocol"]
    caption = (
        f"Measured on {results['source']}: {results['samples']} samples, {len(results['classes'])} classes, "
        f"{words(protocol)}, seed {results['seed']}; mean ± SD over folds. "
        f"Latency: median of one sample, from raw values to the answer, on one thread. taxel {environment['taxel']} at "
        f"{commit(environment)}, {processor(environment)}, {environment['cores']} cores."
    )
    under = stress(folder)
    caption += f" Faults were asked of {under['samples']:,} of {under['of']:,} test samples." if under else ""
    caption += hardening(folder)
    caption += shortcut(results) + chosen(folder, results) + other_statistics(results) + changes(results) + attributes(results)
    return folder.resolve().name, missing(results) + views(folder, results), caption, (folder / "config.toml").read_text()


def check(runs, references):
    """1 if a run gives other scores than its reference, else 0."""
    found = False
    for own in map(reference, runs):
        path = references / f"{own['name']}.json"
        said = differences(own, json.loads(path.read_text())) if path.exists() else ["has no reference"]
        print(f"{own['name']}: {'; '.join(said) or 'as before'}")
        found |= bool(said)
    return int(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=pathlib.Path, nargs="*")
    parser.add_argument("--readme", action="store_true", help="also put the first run's table into README.md")
    parser.add_argument("--partial", action="store_true", help="take runs that are not finished")
    parser.add_argument("--check", action="store_true", help="compare with the references, write nothing")
    parser.add_argument("--configs", action="store_true", help="check that configs still give the digests on the pages")
    args = parser.parse_args()
    if bool(args.run) == args.configs:
        parser.error("name run folders, or --configs alone")
    if args.configs:
        sys.exit(check_configs())
    references = RESULTS / "reference"
    if args.check:
        sys.exit(check(args.run, references))
    references.mkdir(parents=True, exist_ok=True)
    for number, folder in enumerate(args.run):
        name, rows, caption, config = page(folder, args.partial)
        (references / f"{name}.json").write_text(lines(reference(folder)))
        made = origin(config)
        again = commands(name, config, made, (stress(folder) or {}).get("samples"))
        parts = [f"# {name}", "Generated by `scripts/results_table.py`.", again, config_line(config, made),
                 remarks_line(name), rows, caption]
        (RESULTS / f"{name}.md").write_text("\n\n".join(part for part in parts if part) + "\n")
        if args.readme and number == 0:
            readme = ROOT / "README.md"
            brief = table(folder, json.loads((folder / "results.json").read_text()), short=True)
            block = f"<!-- results -->\n{brief}\n\n{caption}\n<!-- end of results -->"
            pattern = re.compile(r"<!-- results -->.*<!-- end of results -->", re.S)
            readme.write_text(pattern.sub(lambda _: block, readme.read_text()))


if __name__ == "__main__":
    main()
