#!/usr/bin/env python3
"""Writes docs/results/<name>.md from run folders, and the README's table from the first of them.

    python3 scripts/results_table.py runs/quickstart [runs/fsr-glove28 ...] [--readme]

Needs Python 3 alone. Every number comes from the run folder: scores and costs from results.json, latency
from timings.jsonl, what hardening changes from the tables of `taxel report`, provenance from environment.json, a
twin's accuracies from twin.jsonl where
scripts/twin/train.py wrote one. Published numbers keep their own column.
"""

import argparse
import json
import pathlib
import re
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[1]


def spread(scores, sd, key):
    return f"{scores[key]:.2f} ± {sd[key]:.2f}" if sd else f"{scores[key]:.2f}"


def latency(folder, network):
    for line in (folder / "timings.jsonl").read_text().splitlines():
        entry = json.loads(line)
        if entry.get("network") == network and "latency_p50_ms" in entry:
            return f"{entry['latency_p50_ms']:.3f}"
    return "–"


def twins(folder):
    path = folder / "twin.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return {line["network"]: line for line in lines}


def lost(folder):
    """Mean loss under faults by network, where the report has tested them."""
    path = folder / "judgement.json"
    stress = json.loads(path.read_text()).get("stress") if path.exists() else None
    return {n["network"]: n["mean_loss"] for n in (stress or {}).get("networks", [])}


def table(folder, results, only=None):
    """All networks of a run, or those named, in their order."""
    networks = results["networks"]
    if only is not None:
        known = {n["network"]: n for n in networks}
        networks = [known[name] for name in only]
    twin, losses = twins(folder), lost(folder)
    published = any(n.get("published") for n in networks)
    head = ["network", "parameters", "MACs", f"accuracy % [{results['source']}]", "macro-F1 %", "latency ms"]
    # A paper that prints all four has them compared.
    full = any("precision" in (n.get("published") or {}) for n in networks)
    sizes = any("megabytes" in (n.get("published") or {}) for n in networks)
    head[4:4] = ["macro precision %", "macro recall %"] if full else []
    head += ["lost under faults, pp"] if losses else []
    head += ["PyTorch twin, same folds %"] if twin else []
    which = "accuracy / precision / recall / F1, " if full else ""
    head += [f"*published*: {which}the paper's own data %"] if published else []
    head += ["*published*: MB, GFLOPs"] if sizes else []
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
            line = twin.get(n["network"])
            row.append(f"{line['twin']:.2f}" if line else "–")
        if published:
            own = n.get("published")
            # [mean, SD], or [mean] where no spread is published.
            printed = [" ± ".join(f"{score:.2f}" for score in own[key]) for key in (scores if full else ["accuracy"]) if own.get(key)] if own else []
            row.append("*" + " / ".join(printed) + "*" if printed else "–")
        if sizes:
            own = n.get("published") or {}
            row.append(f"*{own['megabytes']:g}, {own['gflops']:g}*" if "megabytes" in own else "–")
        rows.append(row)
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines)


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
             "scaled to 0..1, mean over folds, frozen ones 0 (paper 001, Figs. 3 and 4; all layers are in `results.json`).")
    return f"\n\n{words}\n\n{head}" + "\n".join(rows)


def other_statistics(results):
    """What the choice of batch-norm statistics does to the same weights."""
    lines = []
    for kind in ("moving", "population"):
        own = [n for n in results["networks"] if n.get("other_statistics", {}).get("batch_norm") == kind]
        words = [f"`{n['network']}` {n['other_statistics']['accuracy']:.2f} "
                 f"({n['other_statistics']['accuracy'] - n['mean']['accuracy']:+.2f})" for n in own]
        lines += [f"\n\nAccuracy % of the same weights with *{kind}* batch-norm statistics: " + ", ".join(words) + "."] if words else []
    return "".join(lines)


def shortcut(results):
    found = results.get("shortcut")
    if not found:
        return ""
    return (f"\n\n**Confounded?** {len(found['statistics'])} global statistics of a sample ({', '.join(found['statistics'])}) "
            f"alone tell {100 * found['accuracy']:.1f} % of the samples (chance {100 * found['chance']:.1f} %): part of "
            "every score may be the recording, not touch.")


def hardening(folder):
    """The report's tables of what training under faults changes, where there are some."""
    found = [folder / "tables" / f"{name}.md" for name in ("hardening", "unmet-faults")]
    return "".join(f"\n\n{path.read_text().strip()}" for path in found if path.exists())


def commit(environment):
    """Nine digits of the commit, and whether files had changed since."""
    known = environment.get("commit", "unknown")
    return known[:9] + ("-dirty" if known.endswith("-dirty") else "")


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


def page(folder):
    results = json.loads((folder / "results.json").read_text())
    environment = json.loads((folder / "environment.json").read_text())
    if not results["complete"]:
        raise SystemExit(f"{folder}: not complete; finish it with --resume")
    protocol = results["protocol"]
    caption = (
        f"Measured on {results['source']}: {results['samples']} samples, {len(results['classes'])} classes, "
        f"{words(protocol)}, seed {results['seed']}; mean ± SD over folds. "
        f"Latency: median of one sample on one thread. taxel {environment['taxel']} at "
        f"{commit(environment)}, {environment['cpu']}, {environment['cores']} cores."
    )
    caption += hardening(folder)
    caption += shortcut(results) + chosen(folder, results) + other_statistics(results) + changes(results)
    return results["name"], views(folder, results), caption, (folder / "config.toml").read_text()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=pathlib.Path, nargs="+")
    parser.add_argument("--readme", action="store_true", help="also put the first run's table into README.md")
    args = parser.parse_args()
    (ROOT / "docs" / "results").mkdir(parents=True, exist_ok=True)
    for number, folder in enumerate(args.run):
        name, rows, caption, config = page(folder)
        text = f"# {name}\n\nGenerated by `scripts/results_table.py`.\n\n{rows}\n\n{caption}\n\n```toml\n{config}```\n"
        (ROOT / "docs" / "results" / f"{name}.md").write_text(text)
        if args.readme and number == 0:
            readme = ROOT / "README.md"
            block = f"<!-- results -->\n{rows}\n\n{caption}\n<!-- end of results -->"
            pattern = re.compile(r"<!-- results -->.*<!-- end of results -->", re.S)
            readme.write_text(pattern.sub(lambda _: block, readme.read_text()))


if __name__ == "__main__":
    main()
