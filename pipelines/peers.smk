# Rules of the comparison with other programs (peers.yaml).

ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md"]

ruleorder: ball > dataset

rule ball:
    input: "pipelines/peers/pictures.py"
    output: f"{OUT}/volumes/ball.nrrd"
    params: edge=SWEEP["datasets"]["ball"]["edge"]
    shell: "{PYTHON} -B -c 'import sys; sys.path.insert(0, \"pipelines/peers\"); import pictures;"
           " pictures.write_nrrd(\"{output}\", pictures.ball({params.edge}))'"

# VolPack's caller is built here, and only where VolPack is: no part of the project's own build.
rule volpack:
    input: "pipelines/peers/volpack.cpp"
    output: f"{OUT}/volpack"
    params: installed=os.path.exists("/usr/include/volpack.h")
    shell: "if [ {params.installed} = True ]; then g++ -O3 -march=native -o {output} {input} -lvolpack -lm; else : > {output}; fi"

rule table:
    input:
        "pipelines/peers.py", SETTINGS, f"{BIN}/vol-raycast", f"{BIN}/img-compare", f"{OUT}/volumes/ball.nrrd", f"{OUT}/volpack",
        truth=expand(f"{OUT}/truth/{{group}}/reference.exr", group=GROUPS)
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/peers.py {SETTINGS} --bin {BIN} --csv {output.csv} --markdown {output.md}"
