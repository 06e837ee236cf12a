# Rules of the table of extremes (stability.yaml).

PROGRAM = str(Path(BIN).parent / "tests/stability/stability")
ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md"]

# Status 1: a row is not kept, which is for the table to show and for the check to say.
rule measured:
    input: PROGRAM
    output: f"{OUT}/rows.csv"
    threads: ALL_CORES
    shell: "{PROGRAM} > {output} || test $? -eq 1"

rule table:
    input: "pipelines/stability_table.py", found=f"{OUT}/rows.csv"
    output: ENDS
    shell: "{PYTHON} -B pipelines/stability_table.py {input.found} -o {RESULTS}"
