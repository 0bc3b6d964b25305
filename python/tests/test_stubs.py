#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The stubs say what the package has: the same names, members and parameters."""
import ast
import dataclasses
import inspect
import pathlib
import unittest

import waymark

STUBS = ast.parse((pathlib.Path(__file__).parent.parent / "waymark" / "__init__.pyi").read_text())


def parameters(function):
    a = function.args
    names = [arg.arg for arg in a.posonlyargs + a.args + ([a.vararg] if a.vararg else []) + a.kwonlyargs]
    return names + ([a.kwarg.arg] if a.kwarg else [])


def members(cls):
    """Public members of a stub's class: name to its function, or to None for an attribute."""
    out = {}
    for node in cls.body:
        if isinstance(node, ast.FunctionDef):
            out[node.name] = None if any(getattr(d, "id", "") == "property" for d in node.decorator_list) else node
        elif isinstance(node, ast.AnnAssign):
            out[node.target.id] = None
    return {name: node for name, node in out.items() if not name.startswith("_") or name == "__init__"}


class Stubs(unittest.TestCase):
    def test_declare_the_names_of_the_package(self):
        names = {n.name for n in STUBS.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
        names |= {n.target.id for n in STUBS.body if isinstance(n, ast.AnnAssign)}
        self.assertEqual(names, set(waymark.__all__))

    def test_declare_the_parameters_of_functions(self):
        for node in STUBS.body:
            if isinstance(node, ast.FunctionDef) and inspect.isfunction(getattr(waymark, node.name)):
                self.assertEqual(parameters(node), list(inspect.signature(getattr(waymark, node.name)).parameters), node.name)

    def test_declare_the_members_of_classes(self):
        for node in STUBS.body:
            if not isinstance(node, ast.ClassDef):
                continue
            cls, declared = getattr(waymark, node.name), members(node)
            there = {name for name in dir(cls) if not name.startswith("_")}
            if dataclasses.is_dataclass(cls):
                there |= {field.name for field in dataclasses.fields(cls)}
            if issubclass(cls, BaseException):
                there -= set(dir(Exception))
            inherited = {name for base in cls.__mro__[1:] for name in vars(base)}
            missing = there - inherited - set(declared)
            self.assertFalse(missing, f"{node.name}: the stubs lack {sorted(missing)}")
            for name, function in declared.items():
                if function is not None and inspect.isfunction(getattr(cls, name)):
                    signature = inspect.signature(getattr(cls, name))
                    self.assertEqual(parameters(function), list(signature.parameters), f"{node.name}.{name}")
                elif name not in ("__init__", "out", "result", "z", "h", "R", "angles"):  # those are set by the constructor
                    self.assertIn(name, there, f"{node.name}.{name} is not there")

    def test_public_functions_have_docstrings(self):
        for name in waymark.__all__:
            if callable(getattr(waymark, name)) and not name.endswith("Error"):
                self.assertTrue(getattr(waymark, name).__doc__, name)
        for name in ("feed", "step", "play", "finish", "front", "landmarks", "grid"):
            self.assertTrue(getattr(waymark.Robot, name).__doc__)
        for name in ("front", "last", "health", "health_reason", "events", "is_running", "wait", "stop"):
            self.assertTrue(getattr(waymark.Live, name).__doc__)


if __name__ == "__main__":
    unittest.main()
