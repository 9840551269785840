//! The expressions of a case, and the tables in them.

use super::Case;
use super::conditions::Condition;
use super::expression::{Expression, Table};
use super::fibres::{FibreDirection, FibreSpec};
use super::initial::Initial;
use super::key;
use super::schema::MeshSource;

impl Case {
    /// All expressions, with the keys that they stand under.
    pub(crate) fn expressions(&self) -> Vec<(String, &Expression)> {
        let mut found: Vec<(String, &Expression)> = vec![];
        for (name, expression) in &self.mesh.region {
            found.push((key::join("mesh.region", name), expression));
        }
        found.extend(self.mesh.wall.iter().map(|wall| ("mesh.wall.thickness".to_string(), &wall.thickness)));
        found.extend(self.mesh.axis().iter().map(|expression| ("mesh.axis".to_string(), expression)));
        for load in self.loads() {
            found.extend(load.force.iter().map(|expression| (load.key.clone(), expression)));
        }
        for solid in &self.solids {
            let key = format!("{}.fibre-direction", solid.table());
            found.extend(solid.fibre_field().into_iter().flatten().map(|e| (key.clone(), e)));
        }
        for (name, condition) in &self.boundary {
            for (last, data) in condition.data() {
                let key = key::join(&key::join("boundary", name), last);
                found.extend(data.into_iter().map(|data| (key.clone(), data)));
            }
        }
        let fields = self.initial.iter().flat_map(Initial::fields);
        found.extend(fields.flat_map(|(key, pair)| pair.iter().map(|e| (key.to_string(), e))));
        found.extend(self.time.as_ref().map(|time| ("time.step".to_string(), &time.step)));
        found
    }

    /// The same to be changed, without keys.
    fn expressions_mut(&mut self) -> Vec<&mut Expression> {
        let mut found: Vec<&mut Expression> = self.mesh.region.values_mut().collect();
        found.extend(self.mesh.wall.iter_mut().map(|wall| &mut wall.thickness));
        if let MeshSource::Tube { axis, .. } = &mut self.mesh.source {
            found.extend(axis);
        }
        found.extend(self.fluids.iter_mut().flat_map(|fluid| &mut fluid.body_force));
        for solid in &mut self.solids {
            if let Some(FibreSpec { direction: FibreDirection::Field(field), .. }) = &mut solid.fibres {
                found.extend(field);
            }
            found.extend(&mut solid.body_force);
        }
        for (_, datum) in self.boundary.values_mut().flat_map(Condition::data_mut) {
            found.extend(datum.expressions());
        }
        found.extend(self.initial.iter_mut().flat_map(Initial::expressions_mut));
        found.extend(self.time.iter_mut().map(|time| &mut time.step));
        found
    }

    /// All tables, with the keys that they stand under.
    pub(crate) fn tables(&self) -> Vec<(String, &Table)> {
        let expressions = self.expressions().into_iter();
        expressions.flat_map(|(key, e)| e.tables().map(move |table| (key.clone(), table))).collect()
    }

    /// Names the files of all tables anew.
    pub(super) fn name_tables(&mut self, name: impl Fn(&Table) -> String) {
        self.expressions_mut().into_iter().for_each(|expression| expression.name_tables(&name));
    }
}
