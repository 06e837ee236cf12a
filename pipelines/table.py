#!/usr/bin/python3
"""The table of a sweep: every run as CSV, and in Markdown the paper's two tables with what was measured beside."""

import pathlib

import records

EXPLANATION = """\
What differs from the paper. Its transfer function, view and quadrature are not given; here they are those of the scene file
named above each table (orthographic, view 30,20, width 100 voxels, {size} pixels). Its data are the negative half of the
64^3 iron protein{same_data}. Its machine was an SGI O2 with a 174 MHz R5000; here {host}. The normalisation of
its coefficients is not given; here an orthonormal coefficient of level m times 2^(-3m/2) is held against epsilon, so that
both are on the data's scale. The paper takes a coefficient for relevant in its whole support (33 taps for Battle-Lemarie); so
taken, the untruncated Battle-Lemarie filter never allows a longer step on 64^3 voxels, and relevance here is the part of the
support that holds 0.99 of the energy. *Blind* is the paper's rule: a step is taken wherever it leads, and nothing is skipped but by the index.
*Look-ahead* is ours: no step leaves the region that allows it, what the transfer function makes invisible is not sampled, and
segments are integrated by the trapezoid rule. *Classified* is look-ahead with an index of the field as the transfer function shows
it, epsilon / 255 then being an optical depth. Errors against uniform sampling are against that with the run's own quadrature.
Times are medians of {repeat} runs on all cores, in milliseconds, and relative to uniform rectangle sampling
at {distance} with nothing skipped, as published: 9.58 s there. Index construction was published as about 0.05 s.
"""


def short(value):
    return "" if value in ("", None) else f"{float(value):.3g}"


def markdown(header, lines):
    rule = "|" + "|".join("---:" for _ in header) + "|"
    return "\n".join(["| " + " | ".join(header) + " |", rule] + ["| " + " | ".join(line) + " |" for line in lines]) + "\n"


def paper_tables(settings, table):
    swept, published = settings["sweep"], settings["sweep"]["published"]
    dataset = next((d for d in swept["published_on"] if d in settings["datasets"]), None)
    if dataset is None:
        return ""
    wavelets = swept["wavelets"]
    all_epsilons = [0, 1, 3, 5, 10]
    methods = [m for m, entry in swept["methods"].items() if entry.get("index")]
    parts = []
    for scene in sorted({row["scene"] for row in table if row["dataset"] == dataset}):
        found = {(r["method"], r["wavelet"], r["epsilon"]): r
                 for r in table if r["dataset"] == dataset and r["scene"] == scene}
        standard = found.get(("standard", "", ""))
        if standard is None:
            continue
        base = float(standard["time_s"])
        parts.append(f"## {dataset}, scene `{scene}`\n\nStandard method: {1e3 * base:.1f} ms, {standard['samples']} samples, "
                     f"MSE against the truth {short(standard['mse_truth'])}.\n")
        header = ["epsilon"] + [f"{w} {what}" for w in wavelets for what in ["published"] + methods]
        times, errors, samples = [], [], []
        for epsilon in swept["epsilons"]:
            position = all_epsilons.index(epsilon)
            time, error, count = [str(epsilon)], [str(epsilon)], [str(epsilon)]
            for wavelet in wavelets:
                seconds = published["time_s"][wavelet][position]
                time.append(f"{seconds:.2f} s ({seconds / published['standard_s']:.2f})")
                error.append(f"{published['mse'][wavelet][position]:g}")
                count.append("")
                for method in methods:
                    row = found[method, wavelet, str(epsilon)]
                    time.append(f"{1e3 * float(row['time_s']):.1f} ({float(row['time_s']) / base:.2f})")
                    error.append(f"{short(row['mse_uniform'])} / {short(row['mse_truth'])}")
                    count.append(f"{int(row['samples']) / int(standard['samples']):.3f}")
            times.append(time)
            errors.append(error)
            samples.append(count)
        keep = [i for i, name in enumerate(header) if not name.endswith("published")]
        parts += ["Table 1, rendering time in ms (in brackets: over the standard method's):\n", markdown(header, times),
                  "Table 2, mean square error on the byte scale, against uniform sampling at d / against the truth "
                  "(published: against uniform sampling):\n", markdown(header, errors),
                  "Samples over those of the standard method (not published):\n",
                  markdown([header[i] for i in keep], [[line[i] for i in keep] for line in samples])]
    return "\n".join(parts)


def index_times(table):
    seen = {}
    for row in table:
        if row["index_s"]:
            seen.setdefault((row["dataset"], row["method"], row["wavelet"]), []).append(row)
    lines = []
    for (dataset, method, wavelet), group in sorted(seen.items()):
        times = sorted(float(row["index_s"]) for row in group)
        lines.append([dataset, method, wavelet, f"{1e3 * times[len(times) // 2]:.1f}",
                      f"{1e3 * float(group[0]['transform_s']):.1f}"])
    return "## Index construction\n\nMedian over the error bounds and scenes, and the transform before it, in ms.\n\n" + markdown(
        ["data set", "method", "wavelet", "index", "transform"], lines)


def uniform_curve(table):
    lines = []
    for row in table:
        if row["method"] in ("standard", "uniform"):
            lines.append([row["dataset"], row["scene"], row["method"], row["quadrature"], row["step"], row["samples"],
                          f"{1e3 * float(row['time_s']):.1f}", short(row["mse_truth"])])
    return "## Uniform sampling\n\n" + markdown(
        ["data set", "scene", "method", "quadrature", "step", "samples", "ms", "MSE against the truth"], lines)


def main():
    arguments = records.table_arguments(__doc__, "settings")
    settings = records.load(arguments.settings)
    table = list(records.rows(settings))
    records.write_csv(arguments.csv, table)

    sample = next(pathlib.Path(settings["out"]).glob("runs/*/*/standard/*.json"))
    stats = records.load(sample)
    swept = settings["sweep"]
    dataset = next((d for d in swept["published_on"] if d in settings["datasets"]), "")
    text = "# Wavelet-assisted volume ray casting: published and measured\n\n"
    text += EXPLANATION.format(
        size=swept["size"], repeat=swept["repeat"], distance=swept["standard_distance"],
        same_data="" if dataset == "protein64" else ", which is not at hand: below stands the protein phantom",
        host=f"{stats['host']['cpu']}, {stats['host']['threads']} threads, {stats['host']['simd']}, commit {stats['commit']}")
    text += "\n" + paper_tables(settings, table) + "\n" + index_times(table) + "\n" + uniform_curve(table)
    pathlib.Path(arguments.markdown).write_text(text)


if __name__ == "__main__":
    main()
