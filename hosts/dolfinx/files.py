# SPDX-License-Identifier: MIT OR Apache-2.0
"""Files of a run: checkpoint, table of the loop, fields. What is on file does not depend on the partition."""

import hashlib
import json
import os

import h5py
import numpy as np

from host import Step


def replace_file(file, write):
    """Writes under another name and renames: whoever is killed leaves the last good file."""
    part = file.with_name(file.name + ".part")
    write(part)
    with open(part) as written:
        os.fsync(written.fileno())
    os.replace(part, file)


def write_table(file, rows):
    """One column per name, 17 digits."""
    def write(part):
        np.savetxt(part, [list(row.values()) for row in rows], fmt="%.17g", delimiter=",", header=",".join(rows[0]),
                   comments="")

    replace_file(file, write)


def read_table(file):
    names = open(file).readline().strip().split(",")
    return dict(zip(names, np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2).T))


# --- checkpoint ---------------------------------------------------------------------------------------------------------


class CheckpointError(ValueError):
    """A checkpoint of another model, or no checkpoint at all."""


def mesh_digest(model):
    """Of all that input numbers refer to; rank 0."""
    digest = hashlib.sha256()
    for array in (model.points, model.hexahedra, *(a for p in model.pairs for a in (p.lower, p.upper, p.frame, p.area))):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


class Checkpoint:
    """One HDF5 file: displacements by input node, states by pair, the table so far. Rank 0 writes and reads it."""

    def __init__(self, file, solver):
        self.file, self.solver = file, solver
        self.digest = mesh_digest(solver.model) if solver.comm.rank == 0 else None

    def exists(self):
        return self.solver.comm.bcast(self.file.is_file())

    def write(self, number, step, rows):
        """number: of steps done."""
        solver, structure = self.solver, self.solver.structure
        u = structure.displacement(step.x, step.load[0])
        displacement = structure.gather(structure.own_nodes, u.array_r.reshape(-1, 3), structure.nodes)
        state = structure.gather(structure.own_pairs, step.state, structure.pairs)
        if solver.comm.rank != 0:
            return

        def write(part):
            with h5py.File(part, "w") as out:
                out.attrs["model"] = json.dumps(solver.model.key)
                out.attrs["mesh"] = self.digest
                out.attrs["steps"] = number
                out["load"] = step.load
                out["displacement"] = displacement
                out["state"] = state
                out["table"] = np.array([list(row.values()) for row in rows])
                out["table"].attrs["columns"] = list(rows[0])

        replace_file(self.file, write)

    def read(self):
        """Number of steps done, the step, rows of the table."""
        solver, structure = self.solver, self.solver.structure
        found, trouble = None, None
        if solver.comm.rank == 0:
            try:
                found = self._read()
            except (CheckpointError, OSError, KeyError) as error:
                trouble = f"{self.file}: {error}"
        trouble = solver.comm.bcast(trouble)
        if trouble:
            raise CheckpointError(trouble)
        number, load, rows = solver.comm.bcast(found and found[:3])
        displacement, state = found[3:] if found else (None, None)
        x = structure.vector()
        x.array = structure.spread(structure.own_nodes, displacement, 3).ravel()
        x.pointwiseMult(x, solver.free_places())
        return number, Step(x, structure.spread(structure.own_pairs, state, solver.contact.nstate), load), rows

    def _read(self):
        solver = self.solver
        with h5py.File(self.file) as stored:
            for name, here in (("model", json.dumps(solver.model.key)), ("mesh", self.digest)):
                if stored.attrs[name] != here:
                    raise CheckpointError(f"{name} is {stored.attrs[name]}, here it is {here}")
            width = stored["state"].shape[1]
            if width != solver.contact.nstate:
                raise CheckpointError(f"states of {width} numbers, the library has {solver.contact.nstate}")
            columns = list(stored["table"].attrs["columns"])
            rows = [dict(zip(columns, row)) for row in stored["table"][()].tolist()]
            return int(stored.attrs["steps"]), stored["load"][()], rows, stored["displacement"][()], stored["state"][()]


# --- fields -------------------------------------------------------------------------------------------------------------


class Fields:
    """XDMF with HDF5: displacement of all nodes, and on both nodes of every pair contact status (-1: no pair here),
    pressure, slip, dissipated energy per area. `body` tells the bodies apart, so that one can be looked at alone.

    Rank 0 writes, in input numbers. One grid per step holds everything, which all readers of XDMF understand."""

    CONTACT = ("contact_status", "pressure", "slip", "dissipation")

    def __init__(self, file, solver):
        self.solver, self.steps = solver, []
        self.file, self.data = file, file.with_suffix(".fields.h5")
        model = solver.model
        self._column = {name: solver.contact.column(name) for name in ("ContactStatus", "DissipatedEnergy")}
        if solver.comm.rank == 0:
            self._nodes = [np.concatenate([getattr(p, side) for p in model.pairs]) for side in ("lower", "upper")]
            with h5py.File(self.data, "w") as out:
                out["points"], out["hexahedra"], out["body"] = model.points, model.hexahedra, model.body

    def write(self, number, step):
        """number: of the step."""
        structure, column = self.solver.structure, self._column
        u = structure.displacement(step.x, step.load[0])
        own = np.stack([
            step.state[:, column["ContactStatus"]], -step.traction[:, 0], np.linalg.norm(step.opening[:, 1:], axis=1),
            step.state[:, column["DissipatedEnergy"]],
        ], axis=1)
        displacement = structure.gather(structure.own_nodes, u.array_r.reshape(-1, 3), structure.nodes)
        contact = structure.gather(structure.own_pairs, own, structure.pairs)
        if self.solver.comm.rank != 0:
            return
        with h5py.File(self.data, "a") as out:
            group = out.create_group(str(number))
            group["displacement"] = displacement
            for name, values in zip(self.CONTACT, contact.T):
                whole = np.full(structure.nodes, -1.0 if name == "contact_status" else 0.0)
                for nodes in self._nodes:
                    whole[nodes] = values
                group[name] = whole
        self.steps.append(number)
        replace_file(self.file, lambda part: part.write_text(self._xml()))

    def _xml(self):
        nodes, cells = self.solver.structure.nodes, len(self.solver.model.hexahedra)

        def item(path, *size, kind="Float", precision=8):
            return (f'<DataItem Format="HDF" NumberType="{kind}" Precision="{precision}" '
                    f'Dimensions="{" ".join(map(str, size))}">{self.data.name}:/{path}</DataItem>')

        lines = ['<?xml version="1.0"?>', '<Xdmf Version="3.0">', "<Domain>",
                 '<Grid Name="steps" GridType="Collection" CollectionType="Temporal">']
        for number in self.steps:
            lines += [
                '<Grid Name="bodies" GridType="Uniform">', f'<Time Value="{number}"/>',
                f'<Topology TopologyType="Hexahedron" NumberOfElements="{cells}">',
                item("hexahedra", cells, 8, kind="Int"), "</Topology>",
                '<Geometry GeometryType="XYZ">', item("points", nodes, 3), "</Geometry>",
                '<Attribute Name="body" AttributeType="Scalar" Center="Cell">', item("body", cells, kind="Int"),
                "</Attribute>",
                '<Attribute Name="displacement" AttributeType="Vector" Center="Node">',
                item(f"{number}/displacement", nodes, 3), "</Attribute>",
            ]
            for name in self.CONTACT:
                lines += [f'<Attribute Name="{name}" AttributeType="Scalar" Center="Node">',
                          item(f"{number}/{name}", nodes), "</Attribute>"]
            lines.append("</Grid>")
        return "\n".join([*lines, "</Grid>", "</Domain>", "</Xdmf>", ""])
