# SPDX-License-Identifier: Apache-2.0
"""Our source nmea against python3-nmea2, on what real receivers wrote: compare_nmea2.py PRINT_MEASUREMENTS

The peer reads the sentences; here they are put together to epochs, in another way than in the source."""
import datetime
import itertools
import math
import sys

import peers

try:
    import pynmea2
except ImportError:
    peers.skip("python3-nmea2 is not installed")

NAN = math.nan
KNOT = 1852 / 3600
QUALITY = {0: 0, 1: 1, 2: 2, 3: 1, 4: 4, 5: 3}  # GnssFix::Type
MODE = {"A": 1, "D": 2, "R": 4, "F": 3}
EPOCH = datetime.datetime(1970, 1, 1)
HOUR = 3600 * 10**9


def known(value):
    return NAN if value is None or value == "" else float(value)


def sentences(file):
    for line in file.read_bytes().decode("ascii", "replace").replace("\r", "\n").split("\n"):
        if line.startswith("$") and not line.startswith("$P"):
            sentence = pynmea2.parse(line, check=True)
            if sentence.sentence_type in ("GGA", "RMC", "GLL", "GST", "VTG", "ZDA", "HDT"):
                yield sentence


def epochs(file):
    """Lists of sentences of one time; those without a time of their own belong to what comes before."""
    time = None
    for sentence in sentences(file):
        if sentence.sentence_type in ("VTG", "HDT"):
            if time is not None:
                yield time, sentence
        elif sentence.timestamp not in (None, ""):
            time = sentence.timestamp
            yield time, sentence


def date_of(group):
    for sentence in reversed(group):
        if sentence.sentence_type == "RMC" and sentence.datestamp:
            return sentence.datestamp
        if sentence.sentence_type == "ZDA" and sentence.year not in (None, ""):
            return datetime.date(int(sentence.year), int(sentence.month), int(sentence.day))
    return None


def nanoseconds(date, time):
    moment = datetime.datetime.combine(date, time.replace(tzinfo=None)) - EPOCH
    return (moment.days * 86400 + moment.seconds) * 10**9 + moment.microseconds * 1000


def of_type(group, name):
    return [sentence for sentence in group if sentence.sentence_type == name]


def fix_of(group):
    gga = sorted(of_type(group, "GGA"), key=lambda s: s.gps_qual == 0)[:1]
    rmc, gll, gst = of_type(group, "RMC")[:1], of_type(group, "GLL")[:1], of_type(group, "GST")[:1]
    if not gga and not rmc and not gll:
        return None
    if gga:
        kind = QUALITY[gga[0].gps_qual]
    else:
        minimum = (rmc or gll)[0]
        mode = getattr(minimum, "mode_indicator" if rmc else "faa_mode", None)
        kind = (MODE.get(mode, 0) if mode else 5) if minimum.status == "A" else 0
    if kind == 0:
        return [NAN] * 6 + [-1, 0, NAN, NAN]
    where = (gga or rmc or gll)[0]
    values = [where.latitude, where.longitude, NAN, NAN, NAN, NAN, -1, kind, NAN, NAN]
    if gga:
        values[2] = known(gga[0].altitude) + known(gga[0].geo_sep)
        values[5] = known(gga[0].horizontal_dil)
        values[6] = int(gga[0].num_sats)
    if gst and gst[0].std_dev_latitude is not None:
        values[3] = math.sqrt((gst[0].std_dev_latitude**2 + gst[0].std_dev_longitude**2) / 2)
        values[4] = gst[0].std_dev_altitude
    if rmc and rmc[0].status == "A":
        values[8:] = [known(rmc[0].spd_over_grnd) * KNOT, math.radians(known(rmc[0].true_course))]
    elif of_type(group, "VTG"):
        vtg = of_type(group, "VTG")[0]
        values[8:] = [known(vtg.spd_over_grnd_kts) * KNOT, math.radians(known(vtg.true_track))]
    return values


def peer(file):
    rows, date, newest, had_fix, faults = [], None, None, False, 0
    for time, pairs in itertools.groupby(epochs(file), key=lambda pair: pair[0]):
        group = [sentence for _, sentence in pairs]
        date = date_of(group) or date
        values = fix_of(group)
        fix_here = values is not None and values[7] != 0
        if date is None:
            faults += fix_here
            continue
        stamp = nanoseconds(date, time)
        wrong = newest is not None and not 0 < stamp - newest <= HOUR
        faults += wrong
        before, had_fix = had_fix, had_fix or fix_here
        if wrong and before:
            newest = max(newest, stamp)
            continue
        newest = stamp
        if not had_fix:
            continue
        if values is not None:
            rows.append(["gps", "waymark/GnssFix@1", stamp, stamp] + values)
        headings = [s.heading for s in of_type(group, "HDT") if s.heading not in (None, "")]
        if headings:
            rows.append(["compass", "waymark/CompassHeading@1", stamp, stamp, math.radians(float(headings[-1]))])
    return rows, faults


program = sys.argv[1]
for recorded in sorted((peers.data_folder() / "nmea_receivers").glob("*.nmea")):
    text = f"""sensors: [gps, compass]
source: {{ plugin: nmea, file: {recorded}, gnss: {{ sensor: gps }}, heading: {{ sensor: compass }} }}
"""
    ours, bad = peers.ours(program, text)
    theirs, fault_count = peer(recorded)
    peers.compare(recorded.name, ours, theirs, tolerance=1e-15)
    if len(bad) != fault_count:
        sys.exit(f"{recorded.name}: {fault_count} faults of time are expected, but found {bad}")
