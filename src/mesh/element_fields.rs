//! Numbers of each element that a file has beside its mesh: directions of fibres, stiffness factors.

use super::MeshError;
use crate::mechanics::tensor::Vec3;
use nalgebra::Rotation3;
use std::collections::BTreeMap;

/// The numbers of one field, in the order of the elements. They are as in the file, which may have no number for an element: NaN.
#[derive(Clone, Debug, PartialEq)]
pub enum ElementField {
    /// One number for each element.
    Scalars(Vec<f64>),
    /// One vector for each element.
    Vectors(Vec<Vec3>),
}

/// Fields of a mesh by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ElementFields(BTreeMap<String, ElementField>);

impl ElementFields {
    /// The field of a name.
    pub fn get(&self, name: &str) -> Option<&ElementField> {
        self.0.get(name)
    }

    /// The fields by name.
    pub fn into_map(self) -> BTreeMap<String, ElementField> {
        self.0
    }

    /// Names of all fields.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Adds a field.
    ///
    /// # Errors
    /// `Unsupported` if there is one of that name.
    pub fn add(&mut self, name: String, field: ElementField) -> Result<(), MeshError> {
        if self.0.contains_key(&name) {
            return Err(MeshError::Unsupported {
                what: format!("there are two arrays {name:?} of the elements"),
                remedy: "give one of them another name".into(),
            });
        }
        self.0.insert(name, field);
        Ok(())
    }

    /// The fields of the elements of another mesh, of which each lies in, or is, the given element of this one.
    #[must_use]
    pub fn of_elements(&self, origins: &(impl Iterator<Item = usize> + Clone)) -> Self {
        fn picked<T: Copy>(values: &[T], origins: impl Iterator<Item = usize>) -> Vec<T> {
            origins.filter_map(|element| values.get(element).copied()).collect()
        }
        let of_field = |(name, field): (&String, &ElementField)| {
            let field = match field {
                ElementField::Scalars(values) => ElementField::Scalars(picked(values, origins.clone())),
                ElementField::Vectors(values) => ElementField::Vectors(picked(values, origins.clone())),
            };
            (name.clone(), field)
        };
        Self(self.0.iter().map(of_field).collect())
    }

    /// Turns the vectors with the mesh; numbers have no direction and stay.
    pub fn rotate(&mut self, rotation: &Rotation3<f64>) {
        for field in self.0.values_mut() {
            if let ElementField::Vectors(values) = field {
                for v in values {
                    *v = rotation * *v;
                }
            }
        }
    }
}
