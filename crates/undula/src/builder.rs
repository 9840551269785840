//! Cases made in a program: settings, a mesh and a material, checked like a case file.

use crate::case::builtin::text_and_name;
use crate::case::expression::{Functions, OwnFunction};
use crate::case::literal::{number, string};
use crate::case::{Case, OwnMesh, SolidLaw, SolidSpec};
use crate::error::Error;
use crate::mesh::Mesh;
use crate::physics::{OwnLaw, StoredEnergy};
use std::sync::Arc;

/// A case in the making. Nothing is checked before [`CaseBuilder::build`], which tells all mistakes at once.
///
/// ```
/// use undula::CaseBuilder;
/// let case = CaseBuilder::load("fsi3")?.set("mesh.refine", 2).set("fluid.density", 900.0).build()?;
/// assert_eq!(case.mesh.refine, 2);
///
/// let wrong = CaseBuilder::load("fsi3")?.set("fluid.density", -1.0).set("mesh.fine", 2).build();
/// let message = wrong.unwrap_err().to_string();
/// assert!(message.contains("fluid.density=-1.0: expected a number above 0"), "{message}");
/// assert!(message.contains("mesh.fine=2: unknown key"), "{message}");
/// # Ok::<(), undula::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct CaseBuilder {
    text: String,
    name: String,
    settings: Vec<String>,
    mesh: Option<OwnMesh>,
    functions: Functions,
    law: Option<OwnLaw>,
}

impl CaseBuilder {
    /// An empty case called `name`: mesh, bodies and boundary conditions are to be set.
    ///
    /// ```
    /// use undula::{CaseBuilder, Simulation};
    /// let case = CaseBuilder::new("channel")
    ///     .set("mesh.generator", "box")
    ///     .set("mesh.lower", [0.0, 0.0])
    ///     .set("mesh.upper", [3.0, 1.0])
    ///     .set("mesh.cells", [3, 2])
    ///     .set("fluid.density", 1.0)
    ///     .set("fluid.kinematic-viscosity", 0.1)
    ///     .set("boundary.left.condition", "velocity")
    ///     .set("boundary.left.velocity", ["4*y*(1 - y)", "0"])
    ///     .set("boundary.right.condition", "do-nothing")
    ///     .set("boundary.bottom.condition", "no-slip")
    ///     .set("boundary.top.condition", "no-slip")
    ///     .build()?;
    /// let mut simulation = Simulation::new(case, 1)?;
    /// simulation.step()?;
    /// let centre = simulation.fields().at([1.5, 0.5])?;
    /// assert!((centre.velocity[0] - 1.0).abs() < 1e-6);
    /// # Ok::<(), undula::Error>(())
    /// ```
    pub fn new(name: &str) -> CaseBuilder {
        CaseBuilder::from_toml(&format!("name = {}\n", string(name)), &format!("{name}.toml"))
    }

    /// Begins with the text of a case file; messages call it `name`, beside which files are looked for.
    ///
    /// ```
    /// let wrong = undula::CaseBuilder::from_toml("[mesh]\ngenerator = 7\n", "own.toml").build().unwrap_err();
    /// assert!(wrong.to_string().contains("own.toml:2:13: mesh.generator = 7"), "{wrong}");
    /// ```
    pub fn from_toml(text: &str, name: &str) -> CaseBuilder {
        let (functions, settings) = Default::default();
        CaseBuilder { text: text.into(), name: name.into(), settings, mesh: None, functions, law: None }
    }

    /// Begins with the built-in case of that name, else with the case file at that path.
    ///
    /// # Errors
    /// Neither exists, or the file cannot be read.
    pub fn load(path_or_builtin: &str) -> Result<CaseBuilder, Error> {
        let (text, name) = text_and_name(path_or_builtin)?;
        Ok(CaseBuilder::from_toml(&text, &name))
    }

    /// Adds settings `key=value` with values in TOML, as after `--set`.
    ///
    /// ```
    /// let case = undula::CaseBuilder::load("fsi3")?.with(["time.end=1".into(), "solid=none".into()]).build()?;
    /// assert!(case.solids.is_empty());
    /// # Ok::<(), undula::Error>(())
    /// ```
    pub fn with(mut self, settings: impl IntoIterator<Item = String>) -> CaseBuilder {
        self.settings.extend(settings);
        self
    }

    /// Lets expressions call `function` as `table("name", t)`, in place of the file of that name.
    ///
    /// A run with such a function can be resumed by a program that gives one of this name; whether it is the same is not
    /// known.
    ///
    /// ```
    /// use undula::{CaseBuilder, OwnFunction, Simulation};
    /// let pulse = OwnFunction::new(|t| t.sin().powi(2), |t| (2.0 * t).sin());
    /// let case = CaseBuilder::load("cfd3")?
    ///     .function("pulse", pulse)
    ///     .set("mesh.refine", 0)
    ///     .set("boundary.inflow.velocity", [r#"y*(0.41 - y)*table("pulse", t)"#, "0"])
    ///     .build()?;
    /// let mut simulation = Simulation::new(case, 1)?;
    /// let time = simulation.step()?.time;
    /// let inflow = simulation.fields().at([0.0, 0.205])?.velocity[0];
    /// assert!((inflow - 0.205_f64.powi(2) * time.sin().powi(2)).abs() < 1e-12);
    /// # Ok::<(), undula::Error>(())
    /// ```
    pub fn function(mut self, name: &str, function: OwnFunction) -> CaseBuilder {
        self.functions.0.insert(name.into(), function);
        self
    }

    /// Sets the dotted `key`, such as `mesh.refine`. Later settings win.
    pub fn set(mut self, key: &str, value: impl Setting) -> CaseBuilder {
        self.settings.push(format!("{key}={}", value.toml()));
        self
    }

    /// Removes the dotted `key`, or a whole table such as `solid`.
    ///
    /// ```
    /// let rigid = undula::CaseBuilder::load("fsi3")?.remove("solid").build()?;
    /// assert!(rigid.solids.is_empty());
    /// # Ok::<(), undula::Error>(())
    /// ```
    pub fn remove(mut self, key: &str) -> CaseBuilder {
        self.settings.push(format!("{key}=none"));
        self
    }

    /// Takes `mesh` in place of the table `[mesh]`. Settings that follow, such as `mesh.refine`, apply to it.
    ///
    /// The case can be computed, but the file that [`Case::to_toml`] writes cannot be read again.
    pub fn mesh(mut self, mesh: Mesh<2>) -> CaseBuilder {
        self.mesh = Some(OwnMesh(Arc::new(mesh)));
        self.remove("mesh")
    }

    /// Takes the stored energy `law` in place of `solid.law` and its constants. It is kept until the program ends.
    ///
    /// The table `[solid]` must be there with its density, and no other solid. The file that [`Case::to_toml`] writes
    /// cannot be read again.
    pub fn material(mut self, law: impl StoredEnergy + 'static) -> CaseBuilder {
        self.law = Some(OwnLaw::new(law));
        self
    }

    /// Checks the case as if it were read from a file.
    ///
    /// # Errors
    /// All mistakes, each with its key. A stored energy is refused if the solid is under stress at rest or is not stable
    /// there. What needs the mesh, such as the names of boundaries, is checked by [`crate::Simulation::new`].
    pub fn build(self) -> Result<Case, Error> {
        match self.law {
            Some(law) => self.with_law(law),
            None => self.checked(),
        }
    }

    fn checked(&self) -> Result<Case, Error> {
        Ok(Case::from_toml_on(&self.text, &self.name, &self.settings, self.mesh.as_ref(), &self.functions)?)
    }

    /// The case with the law in place of that of `[solid]`.
    fn with_law(mut self, law: OwnLaw) -> Result<Case, Error> {
        let [mu, lambda, stress] = law.at_rest();
        // These stand for the law where its size matters, such as in the scales of the equations.
        for key in ["young", "poisson", "c1", "c2", "bulk"] {
            self = self.remove(&format!("solid.{key}"));
        }
        let sound = mu > 0.0 && lambda + mu > 0.0 && mu.is_finite() && lambda.is_finite();
        let (shown_mu, shown_lambda) = if sound { (mu, lambda) } else { (1.0, 1.0) };
        self = self.set("solid.law", SolidLaw::StVenantKirchhoff.name());
        self = self.set("solid.mu", shown_mu).set("solid.lambda", shown_lambda);
        let mut case = self.checked()?;
        if !sound {
            let message = format!(
                "the stored energy has mu = {mu} Pa and lambda = {lambda} Pa at rest; expected mu > 0 and lambda + mu > 0"
            );
            return Err(case.refuse("solid.law", message));
        }
        if stress.is_nan() || stress > AT_REST * mu {
            let message = format!("the stored energy has a stress of {stress} Pa at rest; expected 0");
            return Err(case.refuse("solid.law", message));
        }
        case.solids.iter_mut().for_each(|SolidSpec { own, .. }| *own = Some(law));
        Ok(case)
    }
}

/// A stress at rest below this part of μ is rounding.
const AT_REST: f64 = 1e-9;

/// A value in a case: numbers, `true` and `false`, words and expressions, and lists of them.
///
/// ```
/// use undula::Setting;
/// assert_eq!(0.5.toml(), "0.5");
/// assert_eq!(["4*y", "0"].toml(), r#"["4*y", "0"]"#);
/// assert_eq!(vec![1, 2].toml(), "[1, 2]");
/// assert_eq!(true.toml(), "true");
/// ```
pub trait Setting {
    /// The value in TOML.
    fn toml(&self) -> String;
}

impl Setting for f64 {
    fn toml(&self) -> String {
        number(*self)
    }
}

macro_rules! plain {
    ($($type:ty),*) => {
        $(impl Setting for $type {
            fn toml(&self) -> String {
                self.to_string()
            }
        })*
    };
}
plain!(bool, i32, u32, u64, usize);

impl Setting for str {
    fn toml(&self) -> String {
        string(self)
    }
}

impl Setting for String {
    fn toml(&self) -> String {
        string(self)
    }
}

impl<T: Setting + ?Sized> Setting for &T {
    fn toml(&self) -> String {
        T::toml(self)
    }
}

impl<T: Setting> Setting for [T] {
    fn toml(&self) -> String {
        format!("[{}]", self.iter().map(Setting::toml).collect::<Vec<_>>().join(", "))
    }
}

impl<T: Setting, const N: usize> Setting for [T; N] {
    fn toml(&self) -> String {
        self.as_slice().toml()
    }
}

impl<T: Setting> Setting for Vec<T> {
    fn toml(&self) -> String {
        self.as_slice().toml()
    }
}
