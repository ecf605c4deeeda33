#!/usr/bin/env python3
"""Checks a report in a real browser: it opens without errors, charts are drawn, tables sort, nothing is clipped.

    taxel report runs/quickstart && python3 scripts/check_report.py runs/quickstart/report.html [--shots FOLDER]

Needs Chromium (`chromium` in the path, or --browser). Opens a copy of the page with a probe in it, in light, dark
and on a phone's width, and prints what the probe found; ends with 1 if anything is wrong. `--shots` saves pictures
of the whole page in all three.
"""

import argparse
import html
import json
import pathlib
import re
import subprocess
import sys
import tempfile

PHONE = 390
WIDE = 1200

FIRST = """<script>window.wrong = [];
addEventListener("error", (event) => wrong.push("error: " + event.message));
const complain = console.error;
console.error = (...words) => { wrong.push("console: " + words.join(" ")); complain(...words); };
</script>"""

# Runs after the page's own script. `wrong` collects complaints, `seen` what was there.
PROBE = """<script>addEventListener("load", () => {
  const seen = {width: innerWidth, height: document.documentElement.scrollHeight};
  const expect = (good, what) => { if (!good) wrong.push(what); };
  for (const details of document.querySelectorAll("details")) details.open = true;
  seen.open = document.documentElement.scrollHeight;
  expect(document.documentElement.scrollWidth <= innerWidth, "the page is wider than the window: " +
    document.documentElement.scrollWidth + " of " + innerWidth);
  expect(performance.getEntriesByType("resource").every((r) => r.name.startsWith("data:")), "something was fetched");
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const shade = (colour) => colour.match(/[0-9.]+/g).slice(0, 3).reduce((sum, part) => sum + Number(part), 0) / 765;
  const [paper, text] = ["backgroundColor", "color"].map((part) => shade(getComputedStyle(document.body)[part]));
  expect(dark ? paper < 0.2 && text > 0.8 : paper > 0.9 && text < 0.2, "colours do not follow the theme");
  seen.dark = dark;
  const charts = [...document.querySelectorAll("svg[role=img]")];
  seen.charts = charts.length;
  expect(charts.length >= LEAST.charts, "charts are missing");
  for (const chart of charts) {
    const name = chart.getAttribute("aria-label").slice(0, 40);
    expect(chart.getAttribute("aria-label").length > 3, "a chart says nothing to screen readers");
    expect(chart.getBoundingClientRect().width > 100, name + ": not drawn");
    expect(chart.querySelectorAll("path, circle, rect, line").length > 3, name + ": nothing in it");
    const [, , width, height] = chart.getAttribute("viewBox").split(" ").map(Number);
    const frame = chart.getBoundingClientRect();
    const scale = width / frame.width;
    const boxes = [...chart.querySelectorAll("text")].map((label) => {
      const box = label.getBoundingClientRect();
      return {text: label.textContent, left: (box.left - frame.left) * scale, right: (box.right - frame.left) * scale,
        top: (box.top - frame.top) * scale, bottom: (box.bottom - frame.top) * scale};
    });
    for (const box of boxes) {
      const inside = box.left > -1 && box.top > -2 && box.right < width + 1 && box.bottom < height + 1;
      expect(inside, name + ": clipped: " + box.text);
    }
    boxes.forEach((a, i) => boxes.slice(0, i).forEach((b) => {
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      expect(across < 2 || down < 4, name + ": '" + a.text + "' lies on '" + b.text + "'");
    }));
  }
  const mark = document.querySelector("svg .tt") || document.createElement("p");
  mark.dispatchEvent(new PointerEvent("pointermove", {clientX: 50, clientY: 50}));
  const tip = document.querySelector("#tip");
  seen.tip = tip.textContent;
  expect(!charts.length || !tip.hidden && tip.textContent.length > 3, "no value to hover over");
  mark.dispatchEvent(new PointerEvent("pointerleave"));
  expect(tip.hidden, "the value stays");
  const tables = [...document.querySelectorAll("table.sortable")];
  seen.tables = tables.length;
  expect(tables.length >= LEAST.tables, "tables are missing");
  let sorted = 0;
  for (const table of tables) {
    const name = table.caption.textContent.slice(0, 40);
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      const button = head.querySelector("button");
      const values = () => [...table.tBodies[0].rows].map((row) => row.cells[column].dataset.order)
        .filter((value) => value !== undefined).map(Number);
      const rows = table.tBodies[0].rows.length;
      for (const way of head.classList.contains("number") ? ["descending", "ascending"] : ["ascending", "descending"]) {
        button.click();
        expect(head.getAttribute("aria-sort") === way, name + ": aria-sort of column " + column);
        expect(table.querySelectorAll("[aria-sort]").length === 1, name + ": two columns are sorted");
        const own = values();
        const up = way === "ascending";
        expect(own.every((v, i) => i === 0 || (up ? own[i - 1] <= v : own[i - 1] >= v)), name + ": column " + column);
        expect(table.tBodies[0].rows.length === rows, name + ": lost rows");
        sorted += 1;
      }
    });
  }
  seen.sorted = sorted;
  for (const image of document.images) expect(image.alt && image.naturalWidth > 0, "a picture is not there");
  for (const link of document.querySelectorAll("a[href^='#']"))
    expect(document.getElementById(link.hash.slice(1)), link.hash + " leads nowhere");
  const levels = [...document.querySelectorAll("h1, h2, h3, h4, h5, h6")].map((head) => Number(head.tagName[1]));
  expect(levels[0] === 1 && levels.every((level, i) => i === 0 || level <= levels[i - 1] + 1), "headings skip a level");
  const report = document.createElement("pre");
  report.id = "probe";
  report.textContent = JSON.stringify({seen, wrong: [...new Set(wrong)]});
  document.body.append(report);
});</script>"""


def browser(binary, folder, *arguments):
    """Runs the browser; what it printed on both outputs."""
    common = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr",
              "--virtual-time-budget=4000", f"--user-data-dir={folder / 'profile'}"]
    done = subprocess.run([binary, *common, *arguments], capture_output=True, text=True, timeout=180)
    return done.stdout, done.stderr


def theme(dark):
    return f"--blink-settings=preferredColorScheme={0 if dark else 1}"


def probe(binary, folder, page, width, dark, least):
    """What the probe saw and what it complains about."""
    text = page.read_text(encoding="utf-8")
    text = text.replace("<head>", f"<head><script>const LEAST = {json.dumps(least)};</script>" + FIRST, 1)
    at = text.rindex("</body>")
    copy = folder / "probed.html"
    copy.write_text(text[:at] + PROBE + text[at:], encoding="utf-8")
    target = copy
    if width == PHONE:
        # A window has a least width; a frame has none. The inner page hands its findings to the outer one.
        inner = copy.read_text(encoding="utf-8").replace(
            "document.body.append(report);", "parent.postMessage(report.textContent, '*');")
        copy.write_text(inner, encoding="utf-8")
        target = folder / "phone.html"
        target.write_text(
            f"<body style='margin:0'><iframe src='probed.html' width={PHONE} height=800 style='border:0'></iframe>"
            "<pre id=probe></pre><script>addEventListener('message', "
            "(event) => { document.querySelector('#probe').textContent = event.data; });</script></body>")
    out, noise = browser(binary, folder, theme(dark), f"--window-size={max(width, 500)},900", "--dump-dom",
                         target.as_uri())
    found = re.search(r'<pre id="?probe"?>(\{.*?)</pre>', out, re.S)
    if not found:
        return {}, [f"the probe did not run: {noise[-400:]}"]
    result = json.loads(html.unescape(found.group(1)))
    console = [line for line in noise.splitlines() if ":CONSOLE" in line]
    return result["seen"], result["wrong"] + console


def shoot(binary, folder, page, shots, name, width, height, dark):
    """A picture of the whole page."""
    target = page
    if width == PHONE:
        target = folder / "frame.html"
        target.write_text(f"<body style='margin:0'><iframe src='{page.as_uri()}' width={PHONE} height={height} "
                          "style='border:0'></iframe></body>")
    picture = shots / f"{name}.png"
    browser(binary, folder, theme(dark), f"--window-size={max(width, PHONE)},{height}", f"--screenshot={picture}",
            target.as_uri())
    return picture if picture.is_file() else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("--browser", default="chromium")
    parser.add_argument("--shots", type=pathlib.Path)
    parser.add_argument("--charts", type=int, default=6, help="least number of charts [6]; 0 for an index.html")
    parser.add_argument("--tables", type=int, default=4, help="least number of tables [4]; 1 for an index.html")
    options = parser.parse_args()
    least = {"charts": options.charts, "tables": options.tables}
    page = options.page.resolve()
    bad = False
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name, width, dark in [("light", WIDE, False), ("dark", WIDE, True), ("phone", PHONE, False)]:
            seen, wrong = probe(options.browser, folder, page, width, dark, least)
            if seen and (seen["dark"] != dark or seen["width"] != width):
                wrong.append(f"{name} was not shown: {seen}")
            print(f"{name}: {seen}")
            for complaint in wrong:
                print(f"  {complaint}")
            bad = bad or bool(wrong)
            if options.shots and seen:
                options.shots.mkdir(parents=True, exist_ok=True)
                height = min(seen["height"], 16000)
                print(f"  {shoot(options.browser, folder, page, options.shots, name, width, height, dark)}")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
