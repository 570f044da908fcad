#!/usr/bin/env python3
"""Claim: another language loads the shared library by its file and gets forces from it, with nothing but phynness.h at hand.

Usage: shared_library_loads_in_python.py LIBRARY MODEL_TXT

The model is of family linear: energy = force . displacement / 2 to rounding (1e-12), and a stiffness that gives the force.
"""

import ctypes
import sys

library, file = sys.argv[1:]
text = open(file, "rb").read()
lib = ctypes.CDLL(library)


def function(name):
    return getattr(lib, "phn_" + name)


def doubles(*values):
    return (ctypes.c_double * len(values))(*values)


class Provenance(ctypes.Structure):
    _fields_ = (
        [(name, ctypes.c_char_p) for name in ("mesh_hash", "physics_hash", "element", "reference")]
        + [(name, ctypes.c_double) for name in ("shear_modulus_Pa", "finer_mean", "finer_p95", "finer_tool_radius_m")]
        + [(name, ctypes.c_int32) for name in ("finer_probes", "finer_nodes", "bound_reference", "reserved")]
    )


class Relaxation(ctypes.Structure):
    _fields_ = [("g", ctypes.c_double * 8), ("tau_s", ctypes.c_double * 8), ("length_m", ctypes.c_double),
                ("n_terms", ctypes.c_int32), ("reserved", ctypes.c_int32)]


class Info(ctypes.Structure):
    _fields_ = (
        [(name, ctypes.c_char_p) for name in ("family", "title", "mesh_hash")]
        + [("max_displacement_m", ctypes.c_double)]
        + [(name, ctypes.POINTER(ctypes.c_int32)) for name in ("active_nodes", "output_nodes", "fixed_nodes")]
        + [(name, ctypes.POINTER(ctypes.c_double)) for name in ("output_points", "fixed_points")]
        + [("triangles", ctypes.POINTER(ctypes.c_int32))]
        + [(name, ctypes.c_char_p * 8) for name in ("field_names", "field_units")]
        + [(name, ctypes.c_int32) for name in ("n_nodes", "n_active", "n_output", "n_fixed", "n_triangles", "n_fields",
                                               "n_levels", "has_energy")]
        + [("provenance", Provenance), ("relaxation", Relaxation), ("reserved", ctypes.c_int32 * 4)]
    )


class Tool(ctypes.Structure):
    _fields_ = [("nodes", ctypes.c_int32 * 3), ("weights", ctypes.c_double * 3), ("displacement", ctypes.c_double * 3),
                ("reserved", ctypes.c_int32 * 2)]


def built(size, init):
    """Memory and address of an object: its bytes are asked for, then it is made."""
    n = ctypes.c_size_t()
    assert size(ctypes.byref(n)) == 0
    memory, handle = ctypes.create_string_buffer(n.value), ctypes.c_void_p()
    assert init(memory, n, ctypes.byref(handle)) == 0
    return memory, handle


assert function("abi_version")() == 1
for struct in (Provenance, Relaxation, Info, Tool):
    name = b"phn_" + struct.__name__.lower().encode()
    assert function("sizeof")(ctypes.c_char_p(name)) == ctypes.sizeof(struct), name
function("status_message").restype = ctypes.c_char_p
length, wrong = ctypes.c_size_t(len(text)), ctypes.c_size_t()
model_memory, model = built(
    lambda n: function("model_size")(text, length, n, None),
    lambda memory, n, handle: function("model_init")(memory, n, text, length, handle, None),
)
data_memory, data = built(
    lambda n: function("data_size")(model, 1, n),
    lambda memory, n, handle: function("data_init")(memory, n, model, 1, handle),
)
info = Info()
assert function("model_info")(model, ctypes.byref(info)) == 0
assert info.family == b"linear" and info.n_active == 4 and info.has_energy == 1 and info.n_levels == 1
assert info.provenance.mesh_hash == info.mesh_hash and len(info.provenance.physics_hash) == 16
assert len(info.mesh_hash) == 16 and b"title " + info.title + b"\n" in text

d, force, energy, stiffness = doubles(0.001, -0.002, 0.003), doubles(0, 0, 0), ctypes.c_double(), doubles(*[0] * 9)
tool = Tool((info.active_nodes[0], -1, -1), (1, 0, 0), tuple(d))
status = function("force")(model, data, ctypes.byref(tool), force, ctypes.byref(energy), stiffness)
assert status >= 0, function("status_message")(status)
work = sum(f * x for f, x in zip(force, d))
assert abs(work / 2 - energy.value) <= 1e-12 * abs(energy.value) > 0
for i in range(3):
    assert abs(sum(stiffness[3 * i + k] * d[k] for k in range(3)) - force[i]) <= 1e-12 * max(map(abs, force))

assert function("model_size")(text[:-1], ctypes.c_size_t(len(text) - 1), ctypes.byref(wrong), None) < 0
