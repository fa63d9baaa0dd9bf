"""A room with one window to the south on a clear day, for EnergyPlus; and EnergyPlus itself, if it is installed."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest

try:
    from pyenergyplus.api import EnergyPlusAPI
except ImportError:
    EnergyPlusAPI = None

needs_energyplus = pytest.mark.skipif(
    EnergyPlusAPI is None, reason="SKIPPED: EnergyPlus is not there; pip install pyenergyplus-lbnl"
)
WINDOW_AREA = 4.5


def room(construction: str) -> dict[str, dict[str, dict]]:
    """Objects in epJSON, 5 m by 5 m by 3 m. Fields are in the order of the IDF, None where it has a blank."""
    corners = [(x, y, z) for z in (0, 3) for x, y in ((0, 0), (5, 0), (5, 5), (0, 5))]
    axes = "xyz"

    def surface(kind: str, *numbers: int) -> dict:
        out = kind != "Floor"
        return {
            "surface_type": kind,
            "construction_name": "wall",
            "zone_name": "room",
            "space_name": None,
            "outside_boundary_condition": "Outdoors" if out else "Adiabatic",
            "outside_boundary_condition_object": None,
            "sun_exposure": "SunExposed" if out else "NoSun",
            "wind_exposure": "WindExposed" if out else "NoWind",
            "view_factor_to_ground": None,
            "number_of_vertices": 4,
            "vertices": [{f"vertex_{a}_coordinate": v for a, v in zip(axes, corners[i], strict=True)} for i in numbers],
        }

    opening = ((1, 0, 2.5), (1, 0, 1), (4, 0, 1), (4, 0, 2.5))
    return {
        "Building": {
            "house": {"north_axis": 0, "terrain": "City", **dict.fromkeys("ab"), "solar_distribution": "FullExterior"}
        },
        "Timestep": {"": {"number_of_timesteps_per_hour": 6}},
        "SimulationControl": {
            "": {
                "do_zone_sizing_calculation": "No",
                "do_system_sizing_calculation": "No",
                "do_plant_sizing_calculation": "No",
                "run_simulation_for_sizing_periods": "Yes",
                "run_simulation_for_weather_file_run_periods": "No",
            }
        },
        "Site:Location": {"Berkeley": {"latitude": 37.87, "longitude": -122.27, "time_zone": -8, "elevation": 52}},
        "GlobalGeometryRules": {
            "": {
                "starting_vertex_position": "UpperLeftCorner",
                "vertex_entry_direction": "Counterclockwise",
                "coordinate_system": "World",
            }
        },
        "SizingPeriod:DesignDay": {
            "day": {
                "month": 9,
                "day_of_month": 21,
                "day_type": "SummerDesignDay",
                "maximum_dry_bulb_temperature": 28,
                "daily_dry_bulb_temperature_range": 10,
                **dict.fromkeys("ab"),
                "humidity_condition_type": "WetBulb",
                "wetbulb_or_dewpoint_at_maximum_dry_bulb": 18,
                **dict.fromkeys("cdef"),
                "barometric_pressure": 100700,
                "wind_speed": 2,
                "wind_direction": 0,
                **dict.fromkeys("ghi"),
                "solar_model_indicator": "ASHRAEClearSky",
                **dict.fromkeys("jklm"),
                "sky_clearness": 1,
            }
        },
        "Material": {
            "brick": {
                "roughness": "Rough",
                "thickness": 0.2,
                "conductivity": 0.7,
                "density": 1800,
                "specific_heat": 840,
            }
        },
        "Construction": {"wall": {"outside_layer": "brick"}},
        "Zone": {"room": {}},
        "BuildingSurface:Detailed": {
            "south": surface("Wall", 4, 0, 1, 5),
            "east": surface("Wall", 5, 1, 2, 6),
            "north": surface("Wall", 6, 2, 3, 7),
            "west": surface("Wall", 7, 3, 0, 4),
            "floor": surface("Floor", 3, 2, 1, 0),
            "roof": surface("Roof", 7, 4, 5, 6),
        },
        "FenestrationSurface:Detailed": {
            "window": {
                "surface_type": "Window",
                "construction_name": construction,
                "building_surface_name": "south",
                **dict.fromkeys("abcd"),
                "number_of_vertices": 4,
                **{
                    f"vertex_{i}_{a}_coordinate": v
                    for i, p in enumerate(opening, 1)
                    for a, v in zip(axes, p, strict=True)
                },
            }
        },
    }


def as_epjson(objects: dict) -> dict:
    """The same without blanks."""
    return {
        kind: {name or kind: {k: v for k, v in fields.items() if v is not None} for name, fields in every.items()}
        for kind, every in objects.items()
    }


def as_idf(objects: dict) -> str:
    """The same as text."""

    def flat(value) -> list:
        return list(itertools.chain(*(v.values() for v in value))) if isinstance(value, list) else [value]

    return "".join(
        ", ".join(
            "" if v is None else str(v)
            for v in itertools.chain([kind], [name] * bool(name), *map(flat, fields.values()))
        )
        + ";\n"
        for kind, every in objects.items()
        for name, fields in every.items()
    )


def simulate(model: Path, folder: Path, *variables: str) -> tuple[str, list[list[float]]]:
    """Return EnergyPlus's error file, and the variables at each time step: those of the window, and of the site."""
    api = EnergyPlusAPI()
    state = api.state_manager.new_state()
    exchange = api.exchange
    keys = [(v, "Environment" if v.startswith("Site") else "window") for v in variables]
    for variable in keys:
        exchange.request_variable(state, *variable)
    found: list[list[float]] = []

    def each(now) -> None:
        if exchange.api_data_fully_ready(now) and not exchange.warmup_flag(now):
            handles = [exchange.get_variable_handle(now, *variable) for variable in keys]
            assert -1 not in handles, dict(zip(variables, handles, strict=True))
            found.append([exchange.get_variable_value(now, handle) for handle in handles])

    api.runtime.callback_end_zone_timestep_after_zone_reporting(state, each)
    api.runtime.set_console_output_status(state, False)
    code = api.runtime.run_energyplus(state, ["-d", str(folder), str(model)])
    # More than 100 MB each.
    api.state_manager.delete_state(state)
    api.runtime.clear_callbacks()
    errors = (folder / "eplusout.err").read_text()
    assert code == 0, errors
    return errors, found


def write_model(path: Path, construction: str, made: Path) -> Path:
    """Write the room and the construction of a file that ``convert`` has written, in its format."""
    version = EnergyPlusAPI().functional.ep_version()
    identifier = {"version_identifier": f"{version.ep_version_major}.{version.ep_version_minor}"}
    objects = {"Version": {"": identifier}} | room(construction)
    if path.suffix == ".idf":
        path.write_text(as_idf(objects) + made.read_text())
    else:
        path.write_text(json.dumps(as_epjson(objects) | json.loads(made.read_text())))
    return path
