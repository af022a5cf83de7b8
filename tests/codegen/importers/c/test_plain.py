"""Plain C in files of C++: what stands around it is taken off, and what is left of C++ is refused."""

import pytest

from codegen.errors import InputError
from codegen.importers import reading as kinds

BODY = "int predict(const float *x) const { if (x[0] <= 1.5f) { return 1; } return x[1] > LIMIT ? 2 : 0; }"
PLAIN = BODY.replace(") const", ")")
FILES = {
    "a.hpp": f"#include <cstdint>\nclass Policy\n{{\npublic:\n constexpr static float LIMIT = 2;\n {BODY}\n}};",
    "a.cpp": f"namespace {{\nconstexpr float LIMIT = 2;\n}}\nnamespace a {{ class B {{ public: {BODY} private: }}; }}",
    "a.ino": f"const float LIMIT = 2;\n{PLAIN}\nvoid setup() {{ pinMode(3, OUTPUT); }}\nvoid loop() {{ delay(3); }}",
    "a.cc": f'extern "C" {{\nstatic constexpr float LIMIT = static_cast<float>(2);\n{PLAIN}\n}}',
    "a.h": f"#define LIMIT 2\n#define EMPTY nullptr\n/* class A {{ */ class A {{ public:\n{BODY}\n}};",
}


@pytest.mark.parametrize("name", FILES)
def test_plain_c_in_cpp_is_read(name):
    (origin,) = kinds.read(FILES[name].encode(), name).values()
    (plain,) = kinds.read(f"#define LIMIT 2\n{PLAIN}".encode(), "a.c").values()
    assert origin.grown.threshold.tolist() == plain.grown.threshold.tolist() and origin.labels == plain.labels


REFUSED = [
    ("class A { public:\nint n = 0;\nint f(float x) { n = n + 1; return n; } };", 3, "n is counted without an end"),
    ("class A {\nint f(float x) { return x > 1; }", 1, "has no end"),
    ("class A : public B {\nint f(float x) { return x > 1; } };", 1, "not C that is understood"),
    ("int f(const float &x)\n{ return x > 1; }", 1, "not C that is understood"),
    ("template <class T>\nint f(T x)\n{ return x > 1; }", 1, "not C that is understood"),
    ("int f(float x)\n{ return std::abs(x) > 1; }", 2, "not C that is understood"),
]


@pytest.mark.parametrize(("text", "line", "said"), REFUSED)
def test_other_cpp_is_refused_with_its_line(text, line, said):
    with pytest.raises(InputError, match=said) as caught:
        kinds.read(text.encode(), "a.cpp")
    assert f"line {line}" in caught.value.where
