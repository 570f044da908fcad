"""Builds the forms of a law file that ffcx compiles."""

from law import call, load


def _constants(names, domain):
    from ufl import Constant

    return {name: Constant(domain) for name in names}


def _bound(function, constants):
    """The law's function with its constants inserted, as a function of fields only."""
    return None if function is None else lambda *fields: call(function, *fields, **constants)


def solids(identifier):
    """The names of a form file for solids: the constants and mechanics.every_element()."""
    import mechanics

    law = load(identifier)
    names = [p.symbol for p in law.parameters] + ["alpha", "cell_share"] + [f.__name__ for f in law.derived]
    constants = _constants(names, mechanics.domain)
    mu = call(law.shear_modulus, **constants)
    forms = mechanics.every_element(
        _bound(law.shape, constants), _bound(law.volumetric, constants), constants[law.kappa],
        mechanics.klaas(constants["alpha"], mu, law.finite), constants["cell_share"], _bound(law.coupling, constants),
        law.finite, _bound(law.inside, constants), 2 / 3 * mu if law.isochoric else None,
    )  # fmt: skip
    return constants | forms


def shells(identifier):
    """The names of a form file for shells: the constants and shell.every_form()."""
    import shell

    law = load(identifier)
    constants = _constants([p.symbol for p in law.parameters], shell.domain)
    forms = shell.every_form(_bound(law.plane_stress, constants), call(law.shear_modulus, **constants), law.finite,
                             _bound(law.squared_thickness, constants))  # fmt: skip
    of_passes = {name: getattr(shell, name) for name in ("zeta", "thickness", "layer", "swap", "shear")}
    return constants | of_passes | {"state": shell.state, "rest": shell.rest} | forms
