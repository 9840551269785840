//! Numbers of the library as objects of Python.

use numpy::PyArray1;
use numpy::prelude::*;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use undula::output::{Field, FieldSnapshot};

/// Fields as `{"time", "points", "cells", "cell_type", "point_data", "cell_data"}`; arrays take the memory of vectors.
pub fn fields(py: Python<'_>, snapshot: FieldSnapshot, time: f64) -> PyResult<Bound<'_, PyAny>> {
    let (cell_type, cells) = snapshot.vtk_cells();
    let per_cell = snapshot.points_per_cell();
    let all = PyDict::new(py);
    all.set_item("time", time)?;
    all.set_item("dimension", snapshot.kind.dim())?;
    let n_points = snapshot.points.len();
    all.set_item("points", PyArray1::from_vec(py, snapshot.points.into_flattened()).reshape([n_points, 3])?)?;
    let n_cells = cells.len() / per_cell;
    all.set_item("cells", PyArray1::from_vec(py, cells).reshape([n_cells, per_cell])?)?;
    all.set_item("cell_type", cell_type)?;
    all.set_item("point_data", arrays(py, snapshot.point_data)?)?;
    all.set_item("cell_data", arrays(py, snapshot.cell_data)?)?;
    Ok(all.into_any())
}

fn arrays(py: Python<'_>, fields: Vec<Field>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for Field { name, components, values } in fields {
        let n = values.len() / components.max(1);
        let array = PyArray1::from_vec(py, values);
        match components {
            1 => all.set_item(name, array)?,
            _ => all.set_item(name, array.reshape([n, components])?)?,
        }
    }
    Ok(all)
}

/// Vectors of the plane with two components again: files have a third one, which is zero.
pub fn in_plane(snapshot: &mut FieldSnapshot) {
    for field in &mut snapshot.point_data {
        if field.components == 3 && !field.name.ends_with("principal-stress") {
            field.components = 2;
            field.values = field.values.as_chunks::<3>().0.iter().flat_map(|v| [v[0], v[1]]).collect();
        }
    }
}

/// A value of a case.
pub fn toml<'py>(py: Python<'py>, value: &toml::Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        toml::Value::String(text) => text.into_bound_py_any(py),
        toml::Value::Integer(n) => n.into_bound_py_any(py),
        toml::Value::Float(x) => x.into_bound_py_any(py),
        toml::Value::Boolean(b) => b.into_bound_py_any(py),
        toml::Value::Datetime(date) => date.to_string().into_bound_py_any(py),
        toml::Value::Array(values) => {
            let list = PyList::empty(py);
            for value in values {
                list.append(toml(py, value)?)?;
            }
            Ok(list.into_any())
        }
        toml::Value::Table(table) => {
            let all = PyDict::new(py);
            for (key, value) in table {
                all.set_item(key, toml(py, value)?)?;
            }
            Ok(all.into_any())
        }
    }
}
