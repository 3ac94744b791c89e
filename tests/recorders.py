"""Files of data recorders, each written by its own library."""

import gc
import warnings
from pathlib import Path

import numpy as np


def write_tdms(path, channels, rate, units, group="rig", starts=None, times=None):
    """Write a waveform channel for each array, as LabVIEW does."""
    from nptdms import ChannelObject, TdmsWriter

    def of(name):
        unit = {} if units.get(name) is None else {"unit_string": units[name]}
        step = {} if rate is None else {"wf_increment": 1.0 / rate}
        offset = {} if starts is None or name not in starts else {"wf_start_offset": starts[name]}
        time = {} if times is None or name not in times else {"wf_start_time": times[name]}
        return {**unit, **step, **offset, **time}

    with TdmsWriter(str(path)) as writer:
        writer.write_segment([ChannelObject(group, name, data, of(name)) for name, data in channels.items()])
    return Path(path)


def write_uff(path, channels, rate, units, binary=1, starts=None):
    """Write a dataset 58 for each array."""
    import pyuff

    sets = [
        pyuff.prepare_58(
            binary=binary, func_type=1, id1=name, rsp_node=i, rsp_dir=3, ref_node=1, ref_dir=3, data=data,
            x=(starts or {}).get(name, 0.0) + np.arange(len(data)) / rate, ord_data_type=4, num_pts=len(data),
            abscissa_spacing=1, abscissa_min=(starts or {}).get(name, 0.0),
            abscissa_inc=1.0 / rate, abscissa_spec_data_type=17, ordinate_spec_data_type=12, orddenom_spec_data_type=0,
            ordinate_axis_units_lab=units.get(name) or "NONE",
        )
        for i, (name, data) in enumerate(channels.items(), start=1)
    ]  # fmt: skip
    Path(path).unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pyuff opens the file twice for binary data
        pyuff.UFF(str(path)).write_sets(sets, mode="add")
        gc.collect()
    return Path(path)


def write_wav(path, channels, rate, units=None):
    """Write 32-bit floats; WAV knows neither names nor units."""
    from scipy.io import wavfile

    wavfile.write(path, int(rate), np.stack(list(channels.values()), axis=1).astype(np.float32))
    return Path(path)


def write_mat(path, channels, rate, units):
    """Write variables, ``fs`` and a struct of units."""
    from scipy.io import savemat

    savemat(path, {**channels, "fs": rate, "units": {name: unit for name, unit in units.items() if unit}})
    return Path(path)


def write_h5(path, channels, rate, units):
    """Write datasets with attributes."""
    import h5py

    with h5py.File(path, "w") as file:
        file.attrs["sampling_rate"] = rate
        for name, data in channels.items():
            file[name] = data
            if units.get(name):
                file[name].attrs["units"] = units[name]
    return Path(path)


def write_csv(path, channels, rate, units, separator=",", comma=False):
    """Write columns with units in their headers."""
    columns = {"time [s]": np.arange(len(next(iter(channels.values())))) / rate}
    columns |= {f"{name} [{units[name]}]" if units.get(name) else name: data for name, data in channels.items()}
    rows = [separator.join(f"{x:.12g}" for x in row) for row in zip(*columns.values(), strict=True)]
    text = "\n".join([separator.join(columns), *(row.replace(".", ",") if comma else row for row in rows), ""])
    Path(path).write_text(text, encoding="utf-8")
    return Path(path)


def write_uff_spectra(path, frequency, spectra, units, binary=1, abscissa=18, even=True):
    """Write a dataset 58 for each array, with frequency as its abscissa: transfer functions, or spectra where real."""
    import pyuff

    sets = [
        pyuff.prepare_58(
            binary=binary, func_type=4 if np.iscomplexobj(data) else 2, id1=name, rsp_node=i, rsp_dir=3, ref_node=1,
            ref_dir=3, data=data, x=frequency, ord_data_type=6 if np.iscomplexobj(data) else 4, num_pts=len(data),
            abscissa_spacing=int(even), abscissa_min=frequency[0] if even else 0.0,
            abscissa_inc=frequency[1] - frequency[0] if even else 0.0, abscissa_spec_data_type=abscissa,
            ordinate_spec_data_type=0, orddenom_spec_data_type=0, ordinate_axis_units_lab=units.get(name) or "NONE",
        )
        for i, (name, data) in enumerate(spectra.items(), start=1)
    ]  # fmt: skip
    Path(path).unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pyuff opens the file twice for binary data
        pyuff.UFF(str(path)).write_sets(sets, mode="add")
        gc.collect()
    return Path(path)


def write_mat_spectra(path, frequency, spectra, units):
    """Write variables, one of them the frequencies, and a struct of units."""
    from scipy.io import savemat

    savemat(path, {"frequency": frequency, **spectra, "units": {name: unit for name, unit in units.items() if unit}})
    return Path(path)


def write_h5_spectra(path, frequency, spectra, units):
    """Write datasets with attributes."""
    import h5py

    with h5py.File(path, "w") as file:
        for name, data in {"frequency": frequency, **spectra}.items():
            file[name] = data
            if units.get(name):
                file[name].attrs["units"] = units[name]
    return Path(path)


def write_npz_spectra(path, frequency, spectra, units):
    """Write arrays; units are suffixes of their names."""
    named = {f"{name}_{units[name].lower()}" if units.get(name) else name: data for name, data in spectra.items()}
    np.savez(path, frequency=frequency, **named)
    return Path(path)


def write_csv_spectra(path, frequency, spectra, units):
    """Write columns with units in their headers, complex ones as two."""
    columns = {"frequency_hz": frequency}
    for name, data in spectra.items():
        unit = f" [{units[name]}]" if units.get(name) else ""
        parts = {"_re": data.real, "_im": data.imag} if np.iscomplexobj(data) else {"": data}
        columns |= {f"{name}{suffix}{unit}": part for suffix, part in parts.items()}
    rows = [",".join(f"{x!r}" for x in map(float, row)) for row in zip(*columns.values(), strict=True)]
    Path(path).write_text("\n".join([",".join(columns), *rows, ""]))
    return Path(path)


SPECTRA_WRITERS = {
    "csv": write_csv_spectra, "dat": write_csv_spectra, "mat": write_mat_spectra, "h5": write_h5_spectra,
    "npz": write_npz_spectra, "uff": write_uff_spectra, "unv": lambda *a: write_uff_spectra(*a, binary=0),
}  # fmt: skip
