"""The world magnetic model by a library (north, east, down in µT)."""
from pygeomag import GeoMag
_m = GeoMag()


def field(lat, lon, km, when=2026.0):
    r = _m.calculate(glat=float(lat), glon=float((lon + 180) % 360 - 180), alt=float(km), time=when)
    return r.x / 1000, r.y / 1000, r.z / 1000
