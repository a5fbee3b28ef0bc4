//! Converts the value of a parameter into an edited scene document.

use super::base_facts::BaseFacts;
use super::distribution::{log_sigma, normal_quantile};
use super::document::{Change, Layer};
use super::misfit::Misfit;
use super::named::{limb_mut, limb_of, pair_of, part_of, striker};
use super::over_surface::{aim, move_over_surface};
use super::rigid_motion::{carry_body, move_body, rotation_of};
use crate::measure::summary::short;
use crate::mechanics::tensor::Vec3;
use crate::mesh::generate::limb_segment::LimbSegment;
use crate::scene::document::{BodyDocument, ContactPairs, SceneDocument};
use nalgebra::{Rotation3, Unit};
use serde_json::{Value, json};

impl Change {
    /// Unit of the parameter's values.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Speed { .. } => "m/s",
            Self::Mass { .. } => "kg",
            Self::Angle { .. } | Self::ImpactAround { .. } => "°",
            Self::Offset { .. }
            | Self::ImpactAlong { .. }
            | Self::ImpactOffset { .. }
            | Self::LayerThickness { .. } => "m",
            Self::Friction { .. } | Self::StiffnessFactor { .. } => "-",
            Self::StiffnessPercentile { .. } => "%",
            Self::Number { pointer } => unit_of_name(pointer),
        }
    }

    /// Value of the parameter in a scene.
    ///
    /// # Errors
    /// Why the change does not fit the scene.
    pub fn value_in(&self, scene: &SceneDocument, facts: &BaseFacts) -> Result<f64, Misfit> {
        Ok(match self {
            Self::Speed { body } => {
                Vec3::from(scene.bodies[striker(scene, body.as_ref())?].velocity_m_per_s).norm()
            }
            Self::Mass { body } => facts.masses_kg[striker(scene, body.as_ref())?],
            Self::Angle { body, .. } | Self::Offset { body, .. } => {
                striker(scene, body.as_ref())?;
                0.0
            }
            Self::ImpactOffset { body, target, along } => {
                aim(scene, facts, [body.as_ref(), target.as_ref()])?.heading(*along)?;
                0.0
            }
            Self::ImpactAround { limb, .. } => limb_of(scene, limb.as_ref())?.1.impact_angle_deg,
            Self::ImpactAlong { limb, .. } => limb_of(scene, limb.as_ref())?.1.impact_along_m,
            Self::LayerThickness { layer, limb } => {
                let limb = limb_of(scene, limb.as_ref())?.1;
                match layer {
                    Layer::Fat => limb.fat_thickness_m,
                    Layer::Skin => limb.skin_thickness_m,
                }
            }
            Self::Friction { between: None } => scene.contact.friction_of_first_pair(),
            Self::Friction { between: Some(names) } => {
                let (index, default) = (pair_of(scene, names)?, scene.contact.friction);
                match &scene.contact.pairs {
                    ContactPairs::List(pairs) => pairs[index].friction.unwrap_or(default),
                    ContactPairs::All(_) => default,
                }
            }
            Self::StiffnessFactor { body, part } => {
                part_of(scene, body, part)?;
                1.0
            }
            Self::StiffnessPercentile { body, part, .. } => {
                part_of(scene, body, part)?;
                50.0
            }
            Self::Number { pointer } => number_at(scene, pointer)?,
        })
    }

    /// Changes a scene to a value of the parameter.
    ///
    /// # Errors
    /// Why the change does not fit the scene.
    pub fn apply(&self, value: f64, scene: &mut SceneDocument, facts: &BaseFacts) -> Result<(), Misfit> {
        match self {
            Self::Speed { body } => {
                let index = striker(scene, body.as_ref())?;
                fits(value >= 0.0, value, "a speed", ">= 0", "turn the velocity round in the scene")?;
                let velocity = Vec3::from(scene.bodies[index].velocity_m_per_s);
                // An unchanged speed keeps the document's numbers exactly: the norm of a vector is rounded.
                if velocity.norm().total_cmp(&value).is_ne() {
                    let direction = velocity.try_normalize(0.0).ok_or_else(|| at_rest(scene, index))?;
                    scene.bodies[index].velocity_m_per_s = (direction * value).into();
                }
            }
            Self::Mass { body } => {
                let index = striker(scene, body.as_ref())?;
                scale_mass(&mut scene.bodies[index], value, value / facts.masses_kg[index]);
            }
            Self::Angle { body, about } => {
                let index = striker(scene, body.as_ref())?;
                let turn = rotation("about", *about, value)?;
                let body = &mut scene.bodies[index];
                body.velocity_m_per_s = (turn * Vec3::from(body.velocity_m_per_s)).into();
            }
            Self::Offset { body, along } => {
                let index = striker(scene, body.as_ref())?;
                let shift = direction("along", *along)?.into_inner() * value;
                move_body(&mut scene.bodies[index], &Rotation3::identity(), &shift);
            }
            Self::ImpactOffset { body, target, along } => {
                let aim = aim(scene, facts, [body.as_ref(), target.as_ref()])?;
                move_over_surface(scene, &aim, *along, value)?;
            }
            Self::ImpactAround { body, limb } => {
                strike(scene, body.as_ref(), limb.as_ref(), &|limb| limb.impact_angle_deg = value)?;
            }
            Self::ImpactAlong { body, limb } => {
                strike(scene, body.as_ref(), limb.as_ref(), &|limb| limb.impact_along_m = value)?;
            }
            Self::LayerThickness { layer, limb } => {
                let index = limb_of(scene, limb.as_ref())?.0;
                if let Some(limb) = limb_mut(&mut scene.bodies[index]) {
                    *match layer {
                        Layer::Fat => &mut limb.fat_thickness_m,
                        Layer::Skin => &mut limb.skin_thickness_m,
                    } = value;
                }
            }
            Self::Friction { between: None } => {
                scene.contact.friction = value;
                if let ContactPairs::List(pairs) = &mut scene.contact.pairs {
                    let own = pairs.iter_mut().filter(|pair| pair.friction.is_some());
                    own.for_each(|pair| pair.friction = Some(value));
                }
            }
            Self::Friction { between: Some(names) } => {
                let index = pair_of(scene, names)?;
                if let ContactPairs::List(pairs) = &mut scene.contact.pairs {
                    pairs[index].friction = Some(value);
                }
            }
            Self::StiffnessFactor { body, part } => {
                let [body, part] = part_of(scene, body, part)?;
                scene.bodies[body].parts[part].material.scale_stiffness(value);
            }
            Self::StiffnessPercentile { body, part, coefficient_of_variation } => {
                let [body, part] = part_of(scene, body, part)?;
                fits(value > 0.0 && value < 100.0, value, "a percentile", "> 0 and < 100", "take 5 to 95")?;
                let factor = (log_sigma(*coefficient_of_variation) * normal_quantile(value / 100.0)).exp();
                scene.bodies[body].parts[part].material.scale_stiffness(factor);
            }
            Self::Number { pointer } => set_number(scene, pointer, value)?,
        }
        Ok(())
    }
}

/// Rejects a value that is inadmissible for any such change.
fn fits(holds: bool, value: f64, what: &str, limit: &str, remedy: &str) -> Result<(), Misfit> {
    holds.then_some(()).ok_or_else(|| Misfit {
        field: "kind",
        value: json!(value),
        message: format!("{what} cannot be {}", short(value)),
        limit: limit.into(),
        remedy: remedy.into(),
    })
}

/// Unit in the suffix of the last member of a pointer, if scene documents use it.
fn unit_of_name(pointer: &str) -> &'static str {
    const UNITS: [(&str, &str); 10] = [
        ("_kg_per_m3", "kg/m³"),
        ("_m_per_s2", "m/s²"),
        ("_m_per_s", "m/s"),
        ("_rad_per_s", "rad/s"),
        ("_per_s", "1/s"),
        ("_pa", "Pa"),
        ("_deg", "°"),
        ("_kg", "kg"),
        ("_m", "m"),
        ("_s", "s"),
    ];
    let is_index = |name: &&str| name.chars().all(|c| c.is_ascii_digit());
    let name = pointer.rsplit('/').find(|name| !is_index(name)).unwrap_or_default();
    UNITS.iter().find(|(end, _)| name.ends_with(end)).map_or("-", |(_, unit)| unit)
}

fn at_rest(scene: &SceneDocument, body: usize) -> Misfit {
    Misfit {
        field: "body",
        value: json!(scene.bodies[body].name),
        message: "this body is at rest: there is no direction in which it could be faster".into(),
        limit: "a body that moves".into(),
        remedy: "give it a velocity in the scene".into(),
    }
}

fn direction(field: &'static str, vector: [f64; 3]) -> Result<Unit<Vec3>, Misfit> {
    let unit = Unit::try_new(Vec3::from(vector), 0.0).filter(|unit| unit.iter().all(|x| x.is_finite()));
    unit.ok_or_else(|| Misfit {
        field,
        value: json!(vector),
        message: "this vector has no direction".into(),
        limit: "a vector of finite length > 0".into(),
        remedy: "give a direction such as [0, 1, 0]".into(),
    })
}

fn rotation(field: &'static str, axis: [f64; 3], degrees: f64) -> Result<Rotation3<f64>, Misfit> {
    Ok(Rotation3::from_axis_angle(&direction(field, axis)?, degrees.to_radians()))
}

/// A new mass [kg], `factor` times that of the base.
fn scale_mass(body: &mut BodyDocument, mass: f64, factor: f64) {
    if let Some(rigid) = &mut body.rigid {
        rigid.density_kg_per_m3 = None;
        rigid.mass_kg = Some(mass);
        rigid.inertia_kg_m2 = rigid.inertia_kg_m2.map(|inertia| inertia.map(|i| i * factor));
    }
    body.parts.iter_mut().for_each(|part| part.density_kg_per_m3 *= factor);
}

/// Moves the impact point on a limb: the projectile follows the rigid motion from the old place on the skin to the new
/// one, including its velocity and spin.
fn strike(
    scene: &mut SceneDocument,
    body: Option<&String>,
    limb: Option<&String>,
    change: &dyn Fn(&mut LimbSegment),
) -> Result<(), Misfit> {
    let projectile = striker(scene, body)?;
    let (index, limb) = limb_of(scene, limb)?;
    let mut changed = limb.clone();
    change(&mut changed);
    let [(from, normal), (to, new_normal)] = [limb, &changed].map(LimbSegment::impact_point);
    // The section lies in x and z: the angle of a normal from +z towards +x is a rotation about +y.
    let angle = |n: &Vec3| n.x.atan2(n.z);
    let turn = Rotation3::from_axis_angle(&Vec3::y_axis(), angle(&new_normal) - angle(&normal));
    let placement = scene.bodies[index].placement.clone();
    if let Some(limb) = limb_mut(&mut scene.bodies[index]) {
        *limb = changed;
    }
    // The limb itself may be rotated and translated; its scaling moves its skin too.
    let (scale, place) =
        placement.as_ref().map_or((1.0, Rotation3::identity()), |p| (p.scale, rotation_of(p)));
    let shift = placement.as_ref().map_or_else(Vec3::zeros, |p| Vec3::from(p.translation_m));
    let turn = place * turn * place.inverse();
    let [from, to] = [from, to].map(|point| place * (point * scale) + shift);
    carry_body(&mut scene.bodies[projectile], &turn, &(to - turn * from), &Vec3::zeros());
    Ok(())
}

fn number_at(scene: &SceneDocument, pointer: &str) -> Result<f64, Misfit> {
    let value = serde_json::to_value(scene).unwrap_or_default();
    value.pointer(pointer).and_then(Value::as_f64).ok_or_else(|| no_number(pointer))
}

fn set_number(scene: &mut SceneDocument, pointer: &str, number: f64) -> Result<(), Misfit> {
    let mut value = serde_json::to_value(&*scene).unwrap_or_default();
    let place = value.pointer_mut(pointer).filter(|v| v.is_number()).ok_or_else(|| no_number(pointer))?;
    let is_count = place.is_u64() && number >= 0.0 && number.fract() == 0.0;
    *place = if is_count { json!(number as u64) } else { json!(number) };
    *scene = serde_json::from_value(value).map_err(|error| Misfit {
        message: format!("the scene cannot have {number} there: {error}"),
        ..no_number(pointer)
    })?;
    Ok(())
}

fn no_number(pointer: &str) -> Misfit {
    Misfit {
        field: "pointer",
        value: json!(pointer),
        message: "the scene document has no number there".into(),
        limit:
            "a JSON pointer (RFC 6901) to a number of the scene, such as /bodies/0/parts/0/density_kg_per_m3"
                .into(),
        remedy: "numbers that are left to their default have to be written out first".into(),
    }
}

/// Difference of two documents as JSON pointers with the new values: applying them to the first gives the second.
pub fn edits(from: &Value, to: &Value) -> Vec<(String, Value)> {
    let mut found = Vec::new();
    collect("", from, to, &mut found);
    found
}

fn collect(here: &str, from: &Value, to: &Value, found: &mut Vec<(String, Value)>) {
    match (from, to) {
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            for (key, value) in a {
                let place = format!("{here}/{}", key.replace('~', "~0").replace('/', "~1"));
                collect(&place, value, &b[key], found);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() && a.iter().any(|v| !v.is_number()) => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                collect(&format!("{here}/{index}"), a, b, found);
            }
        }
        _ if from != to => found.push((here.to_owned(), to.clone())),
        _ => {}
    }
}
