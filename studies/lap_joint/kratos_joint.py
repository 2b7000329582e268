# SPDX-License-Identifier: MIT OR Apache-2.0
"""The bolted lap joint in Kratos Multiphysics: an unmodified release, the contact law is the UMAT of libmepc.so.

Contact is made of zero-thickness interface elements between the faces of each pair. What they and the law want to be
given is told in hosts/kratos, which has the same elements around a box."""

import json
from importlib.metadata import version

import KratosMultiphysics as Kratos
import numpy as np

# hosts/kratos/host.py; it also imports the applications.
from host import DISPLACEMENT, REACTION, TOLERANCE, WATER, WATER_REACTION, NotConverged, contact_material
from KratosMultiphysics.python_linear_solver_factory import ConstructSolver

ITERATIONS = 25  # of Newton's method, then the step is halved
CUTS = 6
HOST_PROPERTIES = [1.0, 2.0]  # PROPS 21, 22: six slots; the law sees half the jump
PACKAGES = [
    f"Kratos{name}" for name in (
        "Multiphysics", "GeoMechanicsApplication", "StructuralMechanicsApplication", "LinearSolversApplication")]


def versions():
    return {package: version(package) for package in PACKAGES}


def interface_cells(mesh, pair):
    """Nodes of a pair's interface elements: lower face, upper face, both around the normal from lower to upper."""
    corners = mesh.points[pair.lower][pair.faces]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    along = np.einsum("qc,qc->q", normal, pair.frame[pair.faces[:, 0], 0]) > 0
    faces = np.where(along[:, None], pair.faces, pair.faces[:, ::-1])
    return np.hstack([pair.lower[faces], pair.upper[faces]])


class KratosJoint:
    """The joint, ready to be moved.

    mesh        -- of mesh.py
    held, moved -- node numbers of the two ends; all three displacements of both are prescribed
    properties  -- PROPS 1 to 20 of each pair's law, by the pair's name"""

    def __init__(self, mesh, held, moved, young, poisson, library, properties):
        self.mesh = mesh
        self.model = Kratos.Model()
        self.part = part = self.model.CreateModelPart("joint", 2)
        part.ProcessInfo[Kratos.DOMAIN_SIZE] = 3
        for name in ("DISPLACEMENT", "REACTION", "VOLUME_ACCELERATION", "VELOCITY", "ACCELERATION", "WATER_PRESSURE",
                     "REACTION_WATER_PRESSURE", "DT_WATER_PRESSURE"):
            part.AddNodalSolutionStepVariable(Kratos.KratosGlobals.GetVariable(name))
        self.nodes = [part.CreateNewNode(number, *point) for number, point in enumerate(mesh.points, 1)]
        self._elements(young, poisson, library, properties)
        self._dofs(held, moved)
        self._strategy()
        self.step, self.displacement = 0, 0.0

    def _elements(self, young, poisson, library, properties):
        part, number = self.part, 0
        none_yet = part.CreateNewProperties(0)
        materials = []

        def add(name, kind, cells, material):
            """A part of the model: its elements, numbered on, and its material."""
            nonlocal number
            model_part = part.CreateSubModelPart(name)
            model_part.AddNodes([int(node) + 1 for node in np.unique(cells)])
            for number, cell in enumerate(cells, number + 1):
                model_part.CreateNewElement(kind, number, [int(node) + 1 for node in cell], none_yet)
            materials.append({
                "model_part_name": f"joint.{name}", "properties_id": len(materials) + 1, "Material": material})
            return list(model_part.Elements)

        steel = {"DENSITY": 1.0, "YOUNG_MODULUS": young, "POISSON_RATIO": poisson}
        add("bodies", "SmallDisplacementElement3D8N", self.mesh.hexahedra,
            {"constitutive_law": {"name": "LinearElastic3DLaw"}, "Variables": steel})
        self.contact = {}
        for pair in self.mesh.pairs:
            cells = interface_cells(self.mesh, pair)
            material = contact_material(3, "memory", library, parameters=properties[pair.name] + HOST_PROPERTIES)
            self.contact[pair.name] = add(pair.name, "UPwSmallStrainInterfaceElement3D8N", cells, material)
        Kratos.ReadMaterialsUtility(self.model).ReadMaterials(Kratos.Parameters(json.dumps({"properties": materials})))

    def _dofs(self, held, moved):
        for node in self.nodes:
            for variable, reaction in zip(DISPLACEMENT, REACTION):
                node.AddDof(variable, reaction)
        for number in np.unique(np.concatenate([[*pair.lower, *pair.upper] for pair in self.mesh.pairs])):
            self.nodes[number].AddDof(WATER, WATER_REACTION)
            self.nodes[number].Fix(WATER)
        for number in (*held, *moved):
            for variable in DISPLACEMENT:
                self.nodes[number].Fix(variable)
        self.moved = [self.nodes[number] for number in moved]

    def _strategy(self):
        # Fastest of those for unsymmetric matrices: amgcl takes 1.8 times as long here, other direct ones 3 or more.
        solver = ConstructSolver(Kratos.Parameters('{"solver_type": "LinearSolversApplication.sparse_lu"}'))
        criterion = Kratos.ResidualCriteria(TOLERANCE, 1e-12)
        criterion.SetEchoLevel(0)
        reactions, reform, move = True, False, False
        self.strategy = Kratos.ResidualBasedNewtonRaphsonStrategy(
            self.part, Kratos.ResidualBasedIncrementalUpdateStaticScheme(), criterion,
            Kratos.ResidualBasedBlockBuilderAndSolver(solver), ITERATIONS, reactions, reform, move)
        self.strategy.SetEchoLevel(0)
        self.strategy.Initialize()
        self.strategy.Check()

    def tighten(self):
        """The first step: nothing moves, the interference presses the parts together."""
        return self.move(0.0)

    def move(self, displacement, cuts=CUTS):
        """One step, halved if it does not converge: force of the moved end, force in the bolt, iterations."""
        start = self.displacement
        try:
            iterations = self._solve(displacement)
        except NotConverged:
            if cuts == 0 or displacement == start:
                raise
            first = self.move((start + displacement) / 2, cuts - 1)[-1]
            iterations = ITERATIONS + first + self.move(displacement, cuts - 1)[-1]
        force = sum(node.GetSolutionStepValue(REACTION[0]) for node in self.moved)
        return force, self.vertical_force("head-washer"), iterations

    def _solve(self, displacement):
        """Iterations of a step; raises NotConverged, having undone it."""
        before = [[node.GetSolutionStepValue(variable) for variable in DISPLACEMENT] for node in self.nodes]
        self.part.CloneTimeStep(float(self.step + 1))
        self.part.ProcessInfo[Kratos.STEP] = self.step + 1
        for node in self.moved:
            node.SetSolutionStepValue(DISPLACEMENT[0], float(displacement))
        self.strategy.InitializeSolutionStep()
        self.strategy.Predict()
        if not self.strategy.SolveSolutionStep():
            # The laws commit in FinalizeSolutionStep: without it only the displacements have to be put back.
            for node, values in zip(self.nodes, before):
                for variable, value in zip(DISPLACEMENT, values):
                    node.SetSolutionStepValue(variable, value)
            raise NotConverged(f"displacement {displacement}")
        iterations = self.part.ProcessInfo[Kratos.NL_ITERATION_NUMBER]
        self.strategy.FinalizeSolutionStep()
        self.step += 1
        self.displacement = displacement
        return iterations

    def vertical_force(self, pair):
        """What the upper face of a horizontal pair is pressed with: the nodal forces of its interface elements."""
        total, forces = 0.0, Kratos.Vector()
        for element in self.contact[pair]:
            element.CalculateRightHandSide(forces, self.part.ProcessInfo)
            # Displacements of the eight nodes, the upper face's after the lower one's, then the water pressures.
            total += np.array(forces)[12:24].reshape(4, 3)[:, 2].sum()
        return abs(total)
