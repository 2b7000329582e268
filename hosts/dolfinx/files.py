# SPDX-License-Identifier: MIT OR Apache-2.0
"""Files of a run: checkpoint, table of the loop, fields. What is on file does not depend on the partition."""

import hashlib
import json
import os

from mpi4py import MPI  # noqa: F401  (before dolfinx: it brings the MPI library)

import dolfinx
import h5py
import numpy as np
from petsc4py import PETSc

from host import Step
from structure import Structure


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
    """XDMF with displacement, and on both nodes of every pair: contact status, pressure, slip, dissipated energy.

    Nodes without a pair have the status -1. The field `body` tells the bodies apart, so that one can be looked at."""

    SCALARS = ("contact_status", "pressure", "slip", "dissipation")

    def __init__(self, file, solver):
        self.solver, structure = solver, solver.structure
        self._file = dolfinx.io.XDMFFile(solver.comm, str(file), "w")
        self._file.write_mesh(structure.mesh)
        self._write_body(structure)
        self._displacement = dolfinx.fem.Function(structure.space, name="displacement")
        self._six = dolfinx.fem.Function(structure.space)
        scalar, self._places = structure.space.sub(0).collapse()
        self._scalars = [dolfinx.fem.Function(scalar, name=name) for name in self.SCALARS]
        self._column = {name: solver.contact.column(name) for name in ("ContactStatus", "DissipatedEnergy")}

    def _write_body(self, structure: Structure):
        cells = structure.mesh.topology.original_cell_index
        model = structure.model
        number = structure.spread(cells, None if model.body is None else model.body[:, None].astype(float), 1)
        body = dolfinx.fem.Function(dolfinx.fem.functionspace(structure.mesh, ("DG", 0)), name="body")
        body.x.array[:len(cells)] = number.ravel()
        body.x.scatter_forward()
        self._file.write_function(body, 0.0)

    def write(self, number, step):
        """number: of the step."""
        structure = self.solver.structure
        u = structure.displacement(step.x, step.load[0])
        own = 3 * len(structure.own_nodes)
        self._displacement.x.array[:own] = u.array_r
        self._displacement.x.scatter_forward()
        self._file.write_function(self._displacement, number)
        values = np.stack([
            step.state[:, self._column["ContactStatus"]] + 1, -step.traction[:, 0],
            np.linalg.norm(step.opening[:, 1:], axis=1), step.state[:, self._column["DissipatedEnergy"]],
        ], axis=1)
        for first in (0, 3):  # the scatter carries three numbers for each node
            three = np.zeros((len(values), 3))
            chosen = values[:, first:first + 3]
            three[:, :chosen.shape[1]] = chosen
            vector = structure.vector()
            structure.from_pairs(np.stack([three, three], axis=1), vector, PETSc.InsertMode.INSERT)
            self._six.x.array[:own] = vector.array_r
            self._six.x.scatter_forward()
            for component, function in enumerate(self._scalars[first:first + 3]):
                function.x.array[:] = self._six.x.array[np.array(self._places) + component]
                if function is self._scalars[0]:
                    function.x.array[:] -= 1
                self._file.write_function(function, number)

    def close(self):
        self._file.close()
