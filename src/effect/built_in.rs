//! The types of this crate's effects in one, which owns what it needs: what the board carries and stores.
//!
//! The lines of the registry make it: each names a family and the types of its effects.

use super::parts::{Form, Parts};

/// A type of effect that is made of parts.
pub(super) trait Typed<C> {
    /// The forms that the type stands for.
    const FORMS: &'static [&'static Form];
    /// Puts it together. The form is one of [`Typed::FORMS`].
    fn of(parts: &Parts<C>) -> Self;
    /// Takes it apart.
    fn parts(&self) -> Parts<C>;
}

/// Makes the list of families, and the type [`BuiltIn`](super::BuiltIn), from lines of
/// `family => Variant(its type), …;`.
macro_rules! built_in_effects {
    ($($family:path => $($variant:ident($effect:ty)),+;)+) => {
        /// The families of this crate, in the order in which they are offered.
        const BUILT_IN: &[&dyn Family] = &[$(&$family),+];

        /// An effect of this crate, with the name of its column in fixed memory: what a calibration carries and stores.
        #[derive(Copy, Debug, PartialEq)]
        #[allow(missing_docs)] // each variant is the effect of that name
        pub enum BuiltIn<T> {
            $($($variant($effect)),+),+
        }

        // Not derived: that would copy variant by variant.
        impl<T: Copy> Clone for BuiltIn<T> {
            fn clone(&self) -> Self {
                *self
            }
        }

        impl<T: Real> BuiltIn<T> {
            /// Takes the effect apart, its numbers in double precision.
            pub fn parts(&self) -> Parts<ColumnName> {
                match self {
                    $($(BuiltIn::$variant(effect) => effect.parts(),)+)+
                }
            }

            /// Puts an effect together; `None` if its form is none of this crate's.
            pub fn of(parts: &Parts<ColumnName>) -> Option<Self> {
                $($(
                    if <$effect as Typed<ColumnName>>::FORMS.contains(&parts.form) {
                        return Some(BuiltIn::$variant(<$effect>::of(parts)));
                    }
                )+)+
                None
            }

            /// The same effect in another precision.
            pub fn cast<U: Real>(&self) -> BuiltIn<U> {
                self.renewed(&self.parts())
            }

            /// An effect of the same type with these parts.
            fn renewed<U: Real>(&self, parts: &Parts<ColumnName>) -> BuiltIn<U> {
                match self {
                    $($(BuiltIn::$variant(_) => BuiltIn::$variant(Typed::of(parts)),)+)+
                }
            }

            /// The form with this number in records.
            pub fn form(tag: u8) -> Option<&'static Form> {
                $($(
                    for form in <$effect as Typed<ColumnName>>::FORMS {
                        if form.tag == tag {
                            return Some(form);
                        }
                    }
                )+)+
                None
            }
        }

        impl<T: Real> Effect<T> for BuiltIn<T> {
            fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::id(effect, out),)+)+ }
            }
            fn name(&self) -> &'static str {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::name(effect),)+)+ }
            }
            fn explanation(&self) -> &'static str {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::explanation(effect),)+)+ }
            }
            fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
                match self { $($(BuiltIn::$variant(effect) => effect.columns(),)+)+ }
            }
            fn needs_gyro(&self) -> bool {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::needs_gyro(effect),)+)+ }
            }
            fn coefficients(&self) -> usize {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::coefficients(effect),)+)+ }
            }
            fn unit(&self) -> &'static str {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::unit(effect),)+)+ }
            }
            fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
                match self { $($(BuiltIn::$variant(effect) => effect.shape(at, shape),)+)+ }
            }
            fn time_s(&self, now_s: f64) -> f64 {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::time_s(effect, now_s),)+)+ }
            }
            fn repeats(&self) -> bool {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::repeats(effect),)+)+ }
            }
            fn reads_centre(&self) -> bool {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::reads_centre(effect),)+)+ }
            }
            #[inline]
            fn delay_s(&self, coefficients: &Coefficients<T>) -> Option<T> {
                match self { $($(BuiltIn::$variant(effect) => Effect::<T>::delay_s(effect, coefficients),)+)+ }
            }
            #[inline]
            fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
                match self { $($(BuiltIn::$variant(effect) => effect.disturbance(at, coefficients),)+)+ }
            }
        }
    };
}
pub(super) use built_in_effects;
