//! The words that names of columns are made of, in lower case.

/// A magnetometer; single letters only with an axis.
pub const FIELD: &[&str] = &[
    "mag",
    "magn",
    "magnet",
    "magneto",
    "magnetometer",
    "magnetometers",
    "magnetic",
    "magnetics",
    "magneticfield",
    "magfield",
    "magadc",
    "bfield",
    "mfield",
    "compass",
    "geomagnetic",
    "magnetfeld",
    "magnetico",
    "magnétique",
    "magnético",
    "mf",
    "magnetometr",
    "b",
    "h",
    "m",
];
/// An accelerometer.
pub const ACCEL: &[&str] = &[
    "a",
    "ac",
    "acc",
    "acce",
    "accel",
    "accelerometer",
    "acceleration",
    "accsmooth",
    "beschleunigung",
    "specificforce",
    "accélération",
    "aceleración",
    "accelerazione",
];
/// A gyroscope.
pub const GYRO: &[&str] = &[
    "g",
    "gy",
    "gyr",
    "gyro",
    "gyros",
    "gyroscope",
    "gyroadc",
    "w",
    "omega",
    "rotationrate",
    "angularvelocity",
    "angularrate",
    "winkelgeschwindigkeit",
];
/// Time.
pub const TIME: &[&str] = &[
    "t",
    "ts",
    "time",
    "times",
    "timestamp",
    "timestamps",
    "stamp",
    "zeit",
    "zeitstempel",
    "temps",
    "tiempo",
    "tempo",
    "date",
    "datetime",
    "clock",
    "elapsed",
    "millis",
    "micros",
    "uptime",
    "timeus",
    "timems",
    "seconds",
    "secs",
    "milliseconds",
    "microseconds",
    "nanoseconds",
    "monitor",
];
/// A temperature.
pub const TEMPERATURE: &[&str] = &["temp", "temperature", "temperatur", "tmp", "température", "temperatura"];
/// Attitude.
pub const ATTITUDE: &[&str] = &[
    "azimuth",
    "pitch",
    "roll",
    "yaw",
    "heading",
    "bearing",
    "quat",
    "quaternion",
    "qw",
    "qx",
    "qy",
    "qz",
    "euler",
    "attitude",
    "orientation",
    "inclination",
    "declination",
];
/// A number of the row.
pub const COUNTER: &[&str] = &[
    "index",
    "idx",
    "seq",
    "sequence",
    "iteration",
    "loopiteration",
    "counter",
    "packet",
    "row",
    "lineno",
    "samplenumber",
];
/// Which sensor a row is of.
pub const INSTANCE: &[&str] =
    &["i", "instance", "sensor", "sensorid", "deviceid", "imu", "magid", "instanceid", "id"];
/// A length.
pub const MAGNITUDE: &[&str] =
    &["norm", "abs", "absolute", "total", "magnitude", "strength", "bt", "btotal", "intensity"];
/// Of a vector, but not the vector: what a driver added, or how sure it is.
pub const ASIDE: &[&str] = &[
    "bias",
    "ofs",
    "offset",
    "offsets",
    "cov",
    "covariance",
    "var",
    "variance",
    "std",
    "stddev",
    "scale",
    "accuracy",
    "residual",
    "mofs",
    "setpoint",
    "error",
    "health",
];
