//! A board in a hand, with an effect that nobody has told it: one attitude after the other, and what its chips feel there.

use crate::cli::HiddenArg;
use crate::failure::{Failure, Outcome};
use ironout_simulation::{EffectSpec, World, WorldOptions};

/// The Earth's field, µT.
pub const FIELD_UT: f64 = 48.0;
/// Noise of the sensor on each axis, µT.
pub const NOISE_UT: f64 = 0.25;
/// Attitudes that the world has.
pub const ATTITUDES: usize = 1400;
/// Hard iron on every axis: the emulated sensor knows no negative fields.
const HARD_IRON_UT: [f64; 3] = [93.0; 3];
/// How strong the hidden effect is, in noises.
const STRENGTH: f64 = 5.0;
/// Attitudes a second of the simulated world.
const RATE_HZ: f64 = 25.0;

impl HiddenArg {
    /// As the board names it.
    pub fn id(self) -> &'static str {
        match self {
            HiddenArg::Temperature => "offset:temp_c",
            HiddenArg::Current => "offset:current_a",
            HiddenArg::Step => "step",
        }
    }

    /// The column that it follows; any where it follows none.
    fn column(self) -> &'static str {
        if self == HiddenArg::Current { "current_a" } else { "temp_c" }
    }
}

/// The board. In peace nothing but its attitude changes; the hidden effect acts once it [works](Turned::work).
pub struct Turned {
    calm: World,
    world: World,
    /// Noise of each axis, µT, over and over.
    noise_ut: Vec<[f64; 3]>,
    /// The value of the column at which the effect is nothing, and from which it goes on.
    reference: f64,
    from: usize,
    effect: HiddenArg,
    attitude: usize,
    /// The attitude at which the work began.
    since: Option<usize>,
}

impl Turned {
    /// At its first attitude, in peace.
    ///
    /// # Errors
    /// The simulated world cannot hide the effect.
    pub fn new(effect: HiddenArg) -> Outcome<Self> {
        let spec = EffectSpec::parse(&format!("{}={STRENGTH}", effect.id()))
            .map_err(|error| Failure::usage(error.to_string()))?;
        let options = WorldOptions {
            seed: 2015,
            field_ut: FIELD_UT,
            hard_iron_ut: Some(HARD_IRON_UT),
            noise_ut: NOISE_UT,
            lsb_ut: 0.0,
            seconds: ATTITUDES as f64 / RATE_HZ,
            rate_hz: RATE_HZ,
            ..WorldOptions::default()
        };
        let calm = World::new(options.clone());
        let world = World::new(WorldOptions { effects: vec![spec], ..options });
        let log = calm.run();
        let axes =
            ["mx_ut", "my_ut", "mz_ut"].map(|name| log.position(name).and_then(|at| log.columns.get(at)));
        let [Some(x), Some(y), Some(z)] = axes else {
            return Err(Failure::usage("the simulation has no magnetometer"));
        };
        let noise_ut = (x.iter().zip(y).zip(z).enumerate())
            .map(|(row, ((x, y), z))| {
                let clean = calm.sensor_ut(row as f64 / RATE_HZ);
                [x - clean[0], y - clean[1], z - clean[2]]
            })
            .collect();
        let reference = world.hidden().first().map_or(0.0, |hidden| hidden.drawn.reference);
        let column = |row: usize| world.covariate(effect.column(), row as f64 / RATE_HZ);
        let from = (0..ATTITUDES).find(|row| column(*row) >= reference).unwrap_or(0);
        Ok(Turned { calm, world, noise_ut, reference, from, effect, attitude: 0, since: None })
    }

    /// Now it works, if it does not yet: from here on the effect acts.
    pub fn work(&mut self) {
        self.since.get_or_insert(self.attitude);
    }

    /// The attitude after so many more.
    pub fn turn(&mut self, attitudes: usize) {
        self.attitude += attitudes;
    }

    /// Attitudes since the work began; `None` in peace.
    fn worked(&self) -> Option<usize> {
        self.since.map(|since| self.attitude - since)
    }

    /// The time in the world: what happens there goes back and forth, but for what happens once.
    fn t_s(&self) -> f64 {
        let (way, there) = (2 * ATTITUDES - 2, ATTITUDES - 1);
        let at = match self.worked() {
            None => self.attitude,
            Some(worked) if self.effect == HiddenArg::Step => worked,
            Some(worked) => self.from + worked,
        } % way;
        let row = if at > there { way - at } else { at };
        row as f64 / RATE_HZ
    }

    /// The field along the sensor's axes, noise and all, µT.
    pub fn field_ut(&self) -> [f64; 3] {
        let worked = self.worked();
        let world = if worked.is_none() { &self.calm } else { &self.world };
        let mut clean = world.sensor_ut(self.t_s());
        if self.effect == HiddenArg::Step && worked.is_some_and(|worked| worked >= ATTITUDES) {
            // On the way back it stays attached.
            let end_s = (ATTITUDES - 1) as f64 / RATE_HZ;
            let (with, without) = (self.world.sensor_ut(end_s), self.calm.sensor_ut(end_s));
            let calm = self.calm.sensor_ut(self.t_s());
            clean = [0, 1, 2].map(|axis| calm[axis] + with[axis] - without[axis]);
        }
        let noise =
            self.noise_ut.get(self.attitude % self.noise_ut.len().max(1)).copied().unwrap_or_default();
        [0, 1, 2].map(|axis| clean[axis] + noise[axis])
    }

    /// The value of a column there.
    pub fn column(&self, name: &str) -> f64 {
        if self.since.is_none() && name == self.effect.column() {
            return self.reference;
        }
        self.world.covariate(name, self.t_s())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_effect_acts_once_it_works() {
        for effect in [HiddenArg::Temperature, HiddenArg::Current, HiddenArg::Step] {
            let mut board = Turned::new(effect).expect("a world");
            let off = |board: &Turned| {
                let own = board.calm.sensor_ut(board.t_s());
                let field = board.field_ut();
                (0..3).map(|axis| (field[axis] - own[axis]).powi(2)).sum::<f64>().sqrt()
            };
            let mean = |board: &mut Turned, attitudes: usize| {
                (0..attitudes).fold(0.0, |sum, _| {
                    board.turn(1);
                    sum + off(board)
                }) / attitudes as f64
            };
            let calm = mean(&mut board, 400);
            board.work();
            board.work();
            // The jump comes in its own time.
            mean(&mut board, 1000);
            let working = mean(&mut board, 800);
            assert!(calm < 3.0 * NOISE_UT && working > 2.0 * calm, "{effect:?}: {calm} {working}");
        }
    }
}
