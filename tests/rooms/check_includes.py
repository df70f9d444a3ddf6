#!/usr/bin/env python3
"""Whether every product source includes what it uses of the headers that cmake/rooms.cmake precompiles.

  check_includes.py [--root FOLDER] [--generated FOLDER]   fails, and names each name without its include

With precompiled headers a source that forgets one of them compiles all the same. So for each of them the names are listed
here that it is needed for; a source that uses one must include a header that gives it, itself or through headers of this
tree (libraries' headers do not count: what they include is their affair). Comments and texts in quotes are not read.
Generated headers stand in --generated, by default build/generated.
"""
import re

import checker

INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
NO_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-zA-Z_])\'(?:\\.|[^\'\\\n])*\'', re.DOTALL)


def standard(*names):
    return r"\bstd::(?:" + "|".join(names) + r")\b"


# name of a precompiled header: (what a source uses of it, other headers that give the same)
NEEDED = {
    "algorithm": (standard("sort", "stable_sort", "clamp", "find_if", "find", "any_of", "all_of", "none_of", "transform",
                           "max_element", "min_element", "minmax_element", "minmax", "lower_bound", "upper_bound", "count_if",
                           "reverse", "remove_if", "unique", "rotate", "nth_element", "binary_search", "max", "min", "copy",
                           "copy_n", "fill", "ranges", "is_sorted", "for_each", "adjacent_find", "mismatch", "partition"), ()),
    "array": (standard("array"), ()),
    "cmath": (standard("sqrt", "abs", "exp", "pow", "log", "log2", "log10", "isfinite", "isnan", "sin", "cos", "tan", "atan",
                       "atan2", "floor", "ceil", "round", "lround", "llround", "hypot", "expm1", "log1p", "tanh", "fmod",
                       "cbrt", "erf", "erfc", "nearbyint", "signbit", "copysign", "fabs", "fmax", "fmin"), ("cstdlib",)),
    "cstdint": (standard("u?int(?:8|16|32|64)_t"), ()),
    "cstdio": (standard("printf", "fprintf", "snprintf", "FILE", "fopen", "fclose", "fputs", "puts", "fflush", "fread",
                        "fwrite", "rename", "putchar", "fputc", "sscanf"), ()),
    "filesystem": (standard("filesystem"), ()),
    "fstream": (standard("ifstream", "ofstream", "fstream"), ()),
    "functional": (standard("function", "greater", "less", "plus", "minus", "ref", "cref", "bind", "hash"), ()),
    "limits": (standard("numeric_limits"), ()),
    "map": (standard("map", "multimap"), ()),
    "memory": (standard("unique_ptr", "shared_ptr", "weak_ptr", "make_unique", "make_shared"), ()),
    "numbers": (standard("numbers"), ()),
    "optional": (standard("optional", "nullopt", "make_optional"), ()),
    "random": (standard("mt19937", "mt19937_64", r"\w+_distribution", "random_device", "seed_seq"), ()),
    "set": (standard("set", "multiset"), ()),
    "span": (standard("span"), ()),
    "sstream": (standard("ostringstream", "istringstream", "stringstream"), ()),
    "stdexcept": (standard("runtime_error", "logic_error", "invalid_argument", "out_of_range", "domain_error", "range_error"), ()),
    "string": (standard("string", "to_string", "stod", "stoi", "stol", "stoul", "stoull", "getline"), ()),
    "utility": (standard("pair", "make_pair", "exchange", "in_place", "declval"), ("map",)),
    "vector": (standard("vector"), ()),
    "CLI/App.hpp": (r"\bCLI::(?!App&)|\bapp\.\w", ("CLI/Error.hpp",)),  # for a parameter, a declaration will do
    "nlohmann/json.hpp": (r"\bnlohmann::", ("nlohmann/json_fwd.hpp",)),
}
# cmake/eigen_kernels.hpp includes all of Eigen/Dense; each of its modules by what is used of it.
EIGEN = {
    "Eigen/Core": (r"\bEigen::(?:Matrix|Vector|RowVector|Array|Index|Ref|Map)\w*", ("Eigen/SparseCore",)),
    "Eigen/Cholesky": (r"\bEigen::LD?LT\b|\.ldlt\(\)|\.llt\(\)", ()),
    "Eigen/LU": (r"\bEigen::(?:Partial|Full)PivLU\b|\.(?:partialPivLu|fullPivLu|inverse|determinant)\(\)", ()),
    "Eigen/QR": (r"\bEigen::\w*HouseholderQR\b|\.(?:\w*[hH]ouseholderQr)\(\)", ()),
    "Eigen/SVD": (r"\bEigen::(?:BDC|Jacobi)SVD\b", ()),
    "Eigen/Eigenvalues": (r"\bEigen::\w*EigenSolver\b", ()),
}
GIVES_EIGEN_CORE = re.compile(r"(?:unsupported/)?Eigen/")
DENSE = "Eigen/Dense"


class Tree:
    def __init__(self, root, generated):
        self.bases = (root, generated)
        self.known = {}

    def read(self, name):
        """The text of a header of this tree and what it includes, of this tree and of libraries."""
        if name not in self.known:
            path = next((base / name for base in self.bases if (base / name).is_file()), None)
            text = path.read_text(errors="replace") if path else ""
            found = INCLUDE.findall(text)
            self.known[name] = (text, [own for own, _ in found if own], {library for _, library in found if library})
        return self.known[name]

    def libraries(self, name):
        """Every library header that the source includes, itself or through headers of this tree."""
        seen, open_names, libraries = {name}, [name], set()
        while open_names:
            _, own, found = self.read(open_names.pop())
            libraries |= found
            for header in own:
                if header not in seen:
                    seen.add(header)
                    open_names.append(header)
        return libraries


def complaints_of(name, tree):
    # Texts keep their lines, so that line numbers stay true.
    code = NO_CODE.sub(lambda match: "\n" * match.group(0).count("\n"), tree.read(name)[0])
    libraries = tree.libraries(name)
    for header, (used, others) in {**NEEDED, **EIGEN}.items():
        if header in libraries or any(other in libraries for other in others):
            continue
        if header in EIGEN and DENSE in libraries:
            continue
        if header == "Eigen/Core" and any(GIVES_EIGEN_CORE.match(library) for library in libraries):
            continue
        match = re.search(used, code)
        if match:
            line = code.count("\n", 0, match.start()) + 1
            yield f"{name}:{line}: uses {match.group(0)} without #include <{header}>"


def precompiled(root):
    """The headers that the build precompiles, as that file names them."""
    names = set()
    text = (root / "cmake" / "rooms.cmake").read_text()
    for block in re.findall(r"set\(spindle_twin_(?:common_headers|headers_of_\w+)[^)]*\)", text):
        names |= set(re.findall(r"<([^>]+)>", block))
    return names


def complaints(root, generated):
    """Lines "file:line: what is missing", and how many sources were read."""
    unlisted = precompiled(root) - set(NEEDED) - {"gtest/gtest.h"}
    found = [f"check_includes.py: NEEDED has no line for <{name}>, which is precompiled" for name in sorted(unlisted)]
    tree, count = Tree(root, generated), 0
    for path in checker.sources_of(root, checker.room_folders(root)):
        count += 1
        found += complaints_of(path.relative_to(root).as_posix(), tree)
    return found, count


if __name__ == "__main__":
    checker.main("check_includes", __doc__, complaints, "{count} sources include what they use")
