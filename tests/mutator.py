"""What tests/mutants changes: writes Rust files in which each change is a choice at run time."""

import re
from pathlib import Path

import tree_sitter
import tree_sitter_rust

ROOT = Path(__file__).resolve().parent.parent
PARSER = tree_sitter.Parser(tree_sitter.Language(tree_sitter_rust.language()))
# What stands for an operator, and for a result: the changes of cargo-mutants, but for fields left out of a struct.
OPERATORS = {
    "==": ["!="], "!=": ["=="], "<": ["==", ">", "<="], ">": ["==", "<", ">="], "<=": [">"], ">=": ["<"],
    "+": ["-", "*"], "-": ["+", "/"], "*": ["+", "/"], "/": ["%", "*"], "%": ["/", "+"],
    "<<": [">>"], ">>": ["<<"], "&": ["|", "^"], "|": ["&", "^"], "^": ["&", "|"], "&&": ["||"], "||": ["&&"],
}
RESULTS = {"bool": ["true", "false"], "Option": ["None"], "Result": ["Ok(Default::default())"]}
RESULTS |= {"S": ["S::zero()", "S::one()"]}
RESULTS |= {f"f{bits}": ["0.0", "1.0", "-1.0"] for bits in (32, 64)}
RESULTS |= {f"u{bits}": ["0", "1"] for bits in (8, 16, 32, 64, "size")}
RESULTS |= {f"i{bits}": ["0", "1", "-1"] for bits in (8, 16, 32, 64)}
# Computed by the compiler, or tests.
LEFT_OUT = {"const_item", "static_item", "const_block", "array_type", "type_arguments", "type_parameters", "enum_variant"}
# Put into the crate: what MUTANT says is a number, 0 for the code as it is, or `trace`, which tells what is reached.
SWITCH = """
extern crate std;
use std::{io::Write, string::String, sync::{LazyLock, atomic::{AtomicBool, Ordering}}};
static ASKED: LazyLock<String> = LazyLock::new(|| std::env::var("MUTANT").unwrap_or_default());
static NUMBER: LazyLock<u32> = LazyLock::new(|| ASKED.parse().unwrap_or(if *ASKED == "trace" { u32::MAX } else { 0 }));
static SEEN: [AtomicBool; COUNT] = [const { AtomicBool::new(false) }; COUNT];
#[inline]
pub fn among(first: u32, end: u32) -> u32 {
    let asked = *NUMBER;
    if first <= asked && asked < end { return asked; }
    if asked == u32::MAX && !SEEN[first as usize].swap(true, Ordering::Relaxed) {
        let _ = std::writeln!(std::io::stderr(), "reached {first} {end}");
    }
    0
}
"""


class Mutator:
    """Writes a file in which each change is a choice on `crate::mutant::among`."""

    def __init__(self, file, first, unviable):
        self.source, self.file, self.next, self.unviable = (ROOT / file).read_bytes(), file, first, unviable
        self.found, self.function = {}, ""
        self.written = self.render(PARSER.parse(self.source).root_node)

    def text(self, node):
        return self.source[node.start_byte : node.end_byte].decode()

    def number(self, node, what, changes):
        """The call that tells which of these changes is asked for, and those that compile, by number."""
        first = self.next
        self.next += len(changes)
        viable = {n: change for n, change in enumerate(changes, first) if n not in self.unviable}
        for n, change in viable.items():
            self.found[n] = [self.file, node.start_point[0] + 1, self.function, f"{what} → {change}"]
        return f"crate::mutant::among({first}, {self.next})", viable

    def choice(self, call, original, changes):
        """A match; the comments tell which mutant it is that does not compile."""
        arms = "".join(f" {n} => /*#{n}*/ {change}," for n, change in changes.items())
        return f"(match {call} {{ 0 => {original},{arms} _ => unreachable!() }})"

    def render(self, node):
        """The text of a node with the choices in it."""
        special = getattr(self, node.type, None) if node.type not in LEFT_OUT else self.text
        return (special and special(node)) or self.children(node)

    def children(self, node, replaced={}):
        out, at, tests = [], node.start_byte, False
        for child in node.children:
            out.append(self.source[at : child.start_byte].decode())
            at = child.end_byte
            left_out = tests and child.type in ("mod_item", "function_item")
            if child.type != "line_comment":
                tests = child.type == "attribute_item" and (tests or self.text(child) in ("#[test]", "#[cfg(test)]"))
            out.append(replaced[child.id] if child.id in replaced else self.text(child) if left_out else self.render(child))
        return "".join(out) + self.source[at : node.end_byte].decode()

    def array_expression(self, node):
        length = node.child_by_field_name("length")
        return length and self.children(node, {length.id: self.text(length)})

    def function_item(self, node):
        if any(child.type == "function_modifiers" and "const" in self.text(child) for child in node.children):
            return self.text(node)
        outer, self.function = self.function, self.text(node.child_by_field_name("name"))
        result = node.child_by_field_name("return_type")
        name = re.match(r"(?:\w+::)*(\w+)", self.text(result)) if result else None
        results = (RESULTS.get(name and name[1]) or ["Default::default()"]) if result else ["()"]
        call, changes = self.number(node, "result", results)
        body = node.child_by_field_name("body")
        returns = "".join(f"if {call} == {n} {{ /*#{n}*/ return {change}; }} " for n, change in changes.items())
        written = self.children(node, {body.id: "{ " + returns + self.children(body)[1:]})
        self.function = outer
        return written

    def impl_item(self, node):
        """Text for people is not asked for."""
        of = node.child_by_field_name("trait")
        return self.text(node) if of and self.text(of).endswith(("Display", "Debug")) else None

    def binary_expression(self, node):
        left, operator, right = (node.child_by_field_name(field) for field in ("left", "operator", "right"))
        sign = self.text(operator)
        call, changes = self.number(operator, sign, OPERATORS[sign])
        l, r = self.render(left), self.render(right)
        if not changes:
            return f"{l} {sign} {r}"
        if sign in ("&&", "||"):
            # Of `a && b`, b is asked if a holds; of `a || b`, if it does not; else a is the answer.
            both = "true" if sign == "&&" else "false"
            return f"(match ({call} == 0, {l}) {{ (is, a) => if a == (is == {both}) {{ {r} }} else {{ a }} }})"
        by = "&" if sign in ("==", "!=", "<", ">", "<=", ">=") else ""
        arms = "".join(f" ({n}, l, r) => /*#{n}*/ l {other} r," for n, other in changes.items())
        return f"(match ({call}, {by}({l}), {by}({r})) {{ (0, l, r) => l {sign} r,{arms} _ => unreachable!() }})"

    def compound_assignment_expr(self, node):
        left, operator, right = (node.child_by_field_name(field) for field in ("left", "operator", "right"))
        sign = self.text(operator)
        call, changes = self.number(operator, sign, [other + "=" for other in OPERATORS[sign[:-1]]])
        l, r = self.render(left), self.render(right)
        return self.choice(call, f"{l} {sign} {r}", {n: f"{l} {other} {r}" for n, other in changes.items()})

    def unary_expression(self, node):
        sign, operand = self.text(node.children[0]), node.children[1]
        if sign not in "-!":
            return None
        call, changes = self.number(node, sign, ["nothing"])
        inner = self.render(operand)
        n = next(iter(changes), None)
        return f"(match ({call}, {inner}) {{ (0, u) => {sign}u, (_, u) => /*#{n}*/ u }})" if changes else f"{sign}{inner}"

    def match_block(self, node):
        """An arm that is left out, if another takes what it took; its guard that always holds, or never."""
        patterns = [arm.child_by_field_name("pattern") for arm in node.named_children if arm.type == "match_arm"]
        rest = any(self.text(pattern) == "_" for pattern in patterns)
        guards = {}
        for pattern in patterns:
            guard = pattern.child_by_field_name("condition")
            if guard and guard.type not in ("let_condition", "let_chain"):
                call, changes = self.number(pattern, f"guard of {self.text(pattern)}", ["true", "false"])
                guards[pattern.id] = self.children(pattern, {guard.id: self.choice(call, self.render(guard), changes)})
            elif rest and not guard and self.text(pattern) != "_":
                call, changes = self.number(pattern, f"arm {self.text(pattern)}", ["none"])
                never = {n: "false" for n in changes}
                guards[pattern.id] = self.text(pattern) + (f" if {self.choice(call, 'true', never)}" if changes else "")
        return self.children(node, {arm.id: self.children(arm, guards) for arm in node.children if arm.type == "match_arm"})
