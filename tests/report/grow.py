#!/usr/bin/env python3
"""grow.py DB N: copies of the landings that are there, in turn, until the campaign has N, each copy in a session of its own."""
import sqlite3
import sys

db = sqlite3.connect(sys.argv[1])
wanted = int(sys.argv[2])
tables = [name for (name,) in db.execute("select name from sqlite_schema where type = 'table' and name not like 'sqlite_%'")]
columns = {t: db.execute("pragma table_info(%s)" % t).fetchall() for t in tables}


def copy(table, where, change):
    names = [c[1] for c in columns[table]]
    own = {"id": None} if "id" in names else {}
    expressions, values = [], []
    for name in names:
        if name in own or name in change:
            expressions.append("?")
            values.append({**own, **change}[name])
        else:
            expressions.append(name)
    return db.execute("insert into %s select %s from %s where %s" % (table, ", ".join(expressions), table, where), values).lastrowid


there = db.execute("select max(id) from landings").fetchone()[0]
for run in range(there + 1, wanted + 1):
    of = (run - 1) % there + 1
    session = copy("sessions", "id = (select session from landings where id = %d)" % of, {})
    copy("landings", "id = %d" % of, {"id": run, "session": session, "board_landing": run})
    survey = copy("surveys", "landing = %d" % of, {"landing": run})
    if survey:
        copy("slack", "survey = (select id from surveys where landing = %d)" % of, {"survey": survey})
    for table in tables:
        names = [c[1] for c in columns[table]]
        if table not in ("landings", "surveys", "simulations", "frames") and "landing" in names:
            copy(table, "landing = %d" % of, {"landing": run, **({"session": session} if "session" in names else {})})
    for (simulation,) in db.execute("select id from simulations where landing = ?", (of,)).fetchall():
        copy("simulation_channels", "simulation = %d" % simulation, {"simulation": copy("simulations", "id = %d" % simulation, {"landing": run})})
db.commit()
