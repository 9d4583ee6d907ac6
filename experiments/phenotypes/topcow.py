"""The figures of the TopCoW benchmark: variant-balanced accuracy and topology match rate.

Both are balanced accuracies over the variants of the truth, of the anterior and of the posterior part by themselves
(CoWBenchmark/TopCoW_Eval_Metrics, topcow24_eval/aggregate/aggregate_all_graph_dicts.py and aggregate_all_topo_dicts.py; Yang et al.,
arXiv:2312.17670):

    (1/V) sum over variants v of (cases of truth v that are right) / (cases of truth v)

A variant is an edge list: (L-A1, Acom, 3rd-A2, R-A1) before, (L-Pcom, L-P1, R-P1, R-Pcom) behind. For the accuracy a case is right
where the two lists are equal. For the match rate it is right where, for every artery of the part (Acom, both ACA and the third A2; both
PCA and both Pcom), the answer has it if and only if the truth has it, in as many pieces (b0), with the same arteries at its ends, and left
and right are not exchanged (metrics/seg_metrics/topology_matching/topology_matching.py). TopCoW counts these in masks. Here arteries are
vessels of a graph: pieces are connected components, and neighbours share a node. Run as a program, it checks itself on examples solved by
hand.
"""

RING = ("L-A1", "R-A1", "AComm", "L-P1", "R-P1", "L-PComm", "R-PComm")
ANTERIOR = ("L-A1", "AComm", "3rd-A2", "R-A1")
POSTERIOR = ("L-PComm", "L-P1", "R-P1", "R-PComm")
PARTS = {"anterior": ANTERIOR, "posterior": POSTERIOR}
CLASSES = {"anterior": ("AComm", "R-ACA", "L-ACA", "3rd-A2"), "posterior": ("R-PCA", "L-PCA", "R-PComm", "L-PComm")}


def edge_list(segments, part):
    """The variant of a part. A segment that is not among `segments` is not scored, and counts as absent."""
    return tuple(int(bool(segments.get(name))) for name in PARTS[part])


def balanced(pairs):
    """Balanced accuracy of (true class, answer): the mean over the true classes of the share that is right; None without a case."""
    of = {}
    for truth, answer in pairs:
        of.setdefault(truth, []).append(truth == answer)
    return sum(sum(right) / len(right) for right in of.values()) / len(of) if of else None


def scored(truth, answer):
    """The answer without the segments that the truth does not score."""
    return {name: there for name, there in answer.items() if name in truth or name == "3rd-A2"}


def variant_balanced_accuracy(pairs, part):
    """Of (true segments, segments of the answer), each a dict from a name to whether it is there."""
    return balanced((edge_list(truth, part), edge_list(scored(truth, answer), part)) for truth, answer in pairs)


def topology(vessels):
    """Per class its pieces and the classes that it meets, of labelled vessels (node, node, class)."""
    pieces, neighbours = {}, {}
    for a, b, name in vessels:
        own = pieces.setdefault(name, [])
        joined = [piece for piece in own if a in piece or b in piece]
        pieces[name] = [piece for piece in own if piece not in joined] + [set().union({a, b}, *joined)]
        neighbours.setdefault(name, set()).update(other for c, d, other in vessels if other != name and {a, b} & {c, d})
    return {name: (len(own), frozenset(neighbours[name])) for name, own in pieces.items()}


def of_segments(segments):
    """The topology of a circle that has these segments, beside its carotids, its basilar artery, A2 and P2 of both sides."""
    vessels = [("tip", "v", "BA")]
    for s in "LR":
        vessels += [(f"{s}i", f"{s}c", f"{s}-ICA"), (f"{s}c", f"{s}t", f"{s}-ICA"), (f"{s}j", f"{s}a", f"{s}-ACA"), (f"{s}k", f"{s}p", f"{s}-PCA")]
        ways = {"A1": (f"{s}t", f"{s}j", f"{s}-ACA"), "P1": ("tip", f"{s}k", f"{s}-PCA"), "PComm": (f"{s}c", f"{s}k", f"{s}-PComm")}
        vessels += [way for name, way in ways.items() if segments.get(f"{s}-{name}")]
    vessels += [("Lj", "Rj", "AComm")] if segments.get("AComm") else []
    vessels += [("Lj", "third", "3rd-A2")] if segments.get("3rd-A2") else []
    return topology(vessels)


def matches(truth, answer, part, exchanged=False):
    """Whether two topologies agree in a part."""
    return not exchanged and all(truth.get(name) == answer.get(name) for name in CLASSES[part])


def topology_match_rate(cases, part):
    """Of (variant of the truth, whether the topology matches), as [`matches`] says."""
    return balanced((variant, variant if right else "FAIL") for variant, right in cases)


def match_rate_of_segments(pairs, part):
    """The topology match rate where segments are all that is known of truth and answer."""
    right = lambda truth, answer: matches(of_segments(truth), of_segments(scored(truth, answer)), part)
    return topology_match_rate(((edge_list(truth, part), right(truth, answer)) for truth, answer in pairs), part)


def sensitivity_and_specificity(pairs, segment):
    """(share of the present that is found, how many), (share of the absent that is found absent, how many); shares may be None."""
    of = lambda there: [bool(answer.get(segment)) == there for truth, answer in pairs if segment in truth and bool(truth[segment]) == there]
    share = lambda right: (sum(right) / len(right) if right else None, len(right))
    return share(of(True)), share(of(False))


def figures(pairs):
    """Exact variants, and the two figures of both parts."""
    exact = [all(bool(answer.get(name)) == bool(there) for name, there in truth.items()) for truth, answer in pairs]
    rates = [rate(pairs, part) for rate in (variant_balanced_accuracy, match_rate_of_segments) for part in PARTS]
    return [sum(exact) / len(exact), *rates]


def field_table(common, methods):
    """A row of figures for each method, a dict from its name to its pairs."""
    head = ["method", "cases", "exact variant", "variant-balanced accuracy, anterior", "posterior", "topology match rate, anterior", "posterior"]
    rows = [[name, len(pairs), *(f"{x:.3f}" for x in figures(pairs))] for name, pairs in methods.items() if pairs]
    return common.table(head, rows)


def segment_table(common, pairs):
    """Sensitivity and specificity of each segment."""
    word = lambda share, count: "" if share is None else f"{share:.3f} of {count}"
    rows = [[name, *(word(*one) for one in sensitivity_and_specificity(pairs, name))] for name in RING]
    return common.table(["segment", "sensitivity", "specificity"], rows)


def check():
    """Examples solved by hand."""
    whole = dict.fromkeys(RING, True)
    lacks = lambda *names: {**whole, **dict.fromkeys(names, False)}
    # Three complete circles before, of which one is found without AComm; two without R-A1, of which one is found: (2/3 + 1/2) / 2.
    pairs = [(whole, whole), (whole, whole), (whole, lacks("AComm")), (lacks("R-A1"), lacks("R-A1")), (lacks("R-A1"), whole)]
    assert edge_list(lacks("R-A1"), "anterior") == (1, 1, 0, 0)
    assert variant_balanced_accuracy(pairs, "anterior") == (2 / 3 + 1 / 2) / 2
    # Behind all are complete and found so.
    assert variant_balanced_accuracy(pairs, "posterior") == 1
    # A third A2 that is not there makes another variant.
    assert variant_balanced_accuracy([(whole, {**whole, "3rd-A2": True})], "anterior") == 0
    # A segment that is not scored counts neither way.
    assert variant_balanced_accuracy([({"L-A1": True}, {"L-A1": True, "AComm": True})], "anterior") == 1
    assert match_rate_of_segments(pairs, "anterior") == (2 / 3 + 1 / 2) / 2 and match_rate_of_segments(pairs, "posterior") == 1
    # The ACA: A1 and A2 are one piece that meets the carotid and AComm; without A1 it is A2 alone, which meets AComm.
    assert of_segments(whole)["R-ACA"] == (1, {"R-ICA", "AComm"}) and of_segments(lacks("R-A1"))["R-ACA"] == (1, {"AComm"})
    assert of_segments(lacks("L-P1", "L-PComm"))["L-PCA"] == (1, frozenset()) and of_segments(whole)["AComm"] == (1, {"L-ACA", "R-ACA"})
    # Arteries that are all found, but AComm in two pieces, or A2 also joined to M1, do not match; nor do exchanged sides.
    sound = [(0, 1, "L-ICA"), (1, 2, "L-ACA"), (2, 3, "AComm"), (3, 4, "R-ACA"), (4, 5, "R-ICA")]
    broken = [*sound[:2], (2, 6, "AComm"), (7, 3, "AComm"), *sound[3:]]
    joined = [*sound, (1, 2, "L-MCA")]
    assert topology(sound)["AComm"] == (1, {"L-ACA", "R-ACA"}) and topology(broken)["AComm"] == (2, {"L-ACA", "R-ACA"})
    assert matches(topology(sound), topology(sound), "anterior") and not matches(topology(sound), topology(sound), "anterior", exchanged=True)
    assert not any(matches(topology(sound), topology(other), "anterior") for other in (broken, joined, sound[:2]))
    assert topology_match_rate([("a", True), ("a", False), ("b", True)], "anterior") == 0.75
    # Of four present AComm three are found, of one absent none.
    some = [(whole, whole)] * 3 + [(whole, lacks("AComm")), (lacks("AComm"), whole)]
    assert sensitivity_and_specificity(some, "AComm") == ((0.75, 4), (0, 1))
    assert sensitivity_and_specificity(some, "L-A1") == ((1, 5), (None, 0))


if __name__ == "__main__":
    check()
    print("topcow.py: the examples solved by hand come out")
