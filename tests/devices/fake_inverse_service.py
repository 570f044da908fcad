#!/usr/bin/env python3
"""A fake of Haply's Inverse service for tests: one client at a time, one Inverse3, a real socket, the standard library alone.

It says the port that it got (`port N`) and writes what happens to the log. It answers each message of the client with one
state update, as Haply documents, unless --answers names something else for the first ones. It checks every message of the
client and ends with status 3 if one is not as documented.

The device is a mass with friction that a spring holds. Each message simulates one millisecond with the force of this
message, so that no result depends on the time that anything takes. After an answer that was left out ("silent"), the last
force acts for as long as it really does; the log tells how long a force that is not zero stayed, and what work it did.
"""
import argparse
import asyncio
import base64
import hashlib
import json
import math
import struct
import sys
import time

MASS_KG, FRICTION_NS_PER_M, HAND_N_PER_M, STEP_S, N_STEPS = 0.08, 0.5, 250.0, 1e-3, 20
CENTER_M = (0.0, -0.12, 0.15)
GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
ACTIONS = ["ok", "not-json", "list", "no-position", "text-position", "infinite", "no-device", "unpowered", "huge", "scaled",
           "late", "twice", "unasked", "ping", "fragments", "silent", "close", "close-half", "vanish", "deep", "deep-scale"]
GREETINGS = ["ok", "not-json", "list", "none", "two", "no-id", "no-position", "uncalibrated", "scaled", "silent", "close",
             "not-websocket", "control-characters", "deep", "deep-scale"]
DEEP = "[" * 100000 + "]" * 100000


class Body:
    def __init__(self):
        self.x, self.v, self.work_J, self.gross_J, self.time_s = [0.0] * 3, [0.0] * 3, 0.0, 0.0, 0.0

    def hand(self):
        """Where the hand wants to be, from the center."""
        t = self.time_s
        return [0.004 * math.sin(9 * t), 0.003 * math.sin(13 * t), 0.01 * math.sin(7 * t)]

    def step(self, force):
        dt = STEP_S / N_STEPS
        for _ in range(N_STEPS):
            wanted = self.hand()
            moved = 0.0
            for i in range(3):
                total = force[i] + HAND_N_PER_M * (wanted[i] - self.x[i]) - FRICTION_NS_PER_M * self.v[i]
                self.v[i] += dt * total / MASS_KG
                self.x[i] += dt * self.v[i]
                moved += force[i] * dt * self.v[i]
            self.work_J += moved
            self.gross_J += abs(moved)
            self.time_s += dt

    def position(self):
        return [c + x for c, x in zip(CENTER_M, self.x)]


def vector(v):
    return {"x": v[0], "y": v[1], "z": v[2]}


class Service:
    def __init__(self, options, log):
        self.options, self.log_file, self.body = options, log, Body()
        self.answers = options.answers.split(",") if options.answers else []
        self.force, self.n, self.violations = [0.0] * 3, 0, 0
        self.clients_left, self.finished = options.clients, asyncio.Event()
        self.silent_since, self.left_s, self.left_J = None, 0.0, 0.0

    def log(self, text):
        print(text, file=self.log_file, flush=True)

    def violation(self, text):
        self.violations += 1
        self.log("violation: " + text)

    def device(self, with_config):
        state = {"cursor_position": vector(self.body.position()), "cursor_velocity": vector(self.body.v),
                 "current_cursor_force": vector(self.reported()), "control_mode": "idle",
                 "transform": {"position": vector([0, 0, 0]), "scale": vector([1, 1, 1])}}
        status = {"calibrated": True, "in_use": False, "power_supply": True, "ready": True, "started": True}
        device = {"device_id": "049D", "state": state, "status": status}
        if with_config:
            device["config"] = {"type": "inverse3", "handedness": "right", "basis": {"permutation": "XYZ"},
                                "mount": {"position": vector([0, 0, 0]), "scale": vector([1, 1, 1])}}
        return device

    def reported(self):
        return self.force if self.options.reports == "commanded" else [0.0, 0.0, float(self.options.reports)]

    def greeting(self):
        kind, device = self.options.greeting, self.device(True)
        devices = {"none": [], "two": [device, dict(device, device_id="04A1")]}.get(kind, [device])
        if kind == "not-json":
            return "hello"
        if kind == "list":
            return "[1, 2]"
        if kind == "no-id":
            del device["device_id"]
        if kind == "no-position":
            del device["state"]["cursor_position"]
        if kind == "uncalibrated":
            device["status"]["calibrated"] = False
        if kind == "scaled":
            device["config"]["mount"]["scale"] = vector([1000, 1000, 1000])
        if kind == "control-characters":
            device["device_id"] = "04\n9D\x1b[31m"
            return json.dumps({"inverse3": [device, device]})
        if kind == "deep":
            return '{"inverse3": [{"device_id": "049D", "state": {"cursor_position": ' + DEEP + "}}]}"
        if kind == "deep-scale":
            return '{"inverse3": [{"device_id": "049D", "config": {"mount": {"scale": ' + DEEP + "}}}]}"
        return json.dumps({"session_id": 7, "inverse3": devices})

    def update(self, kind):
        device = self.device(False)
        if kind == "not-json":
            return '{"inverse3": [{"device_id": "04'
        if kind == "list":
            return "[]"
        if kind == "no-device":
            return json.dumps({"inverse3": []})
        if kind == "no-position":
            del device["state"]["cursor_position"]
        if kind == "text-position":
            device["state"]["cursor_position"]["y"] = "0.1"
        if kind == "scaled":
            device["state"]["transform"]["scale"] = vector([2, 2, 2])
        if kind == "unpowered":
            device["status"]["power_supply"] = False
        if kind == "deep":
            return '{"inverse3": [{"device_id": "049D", "state": {"cursor_position": ' + DEEP + "}}]}"
        if kind == "deep-scale":
            return json.dumps({"inverse3": [device]}).replace('"scale": {', '"scale": ' + DEEP + ', "was": {')
        text = json.dumps({"inverse3": [device]})
        if kind == "infinite":
            text = text.replace('"cursor_position": {"x": ', '"cursor_position": {"x": 1e999, "was": ')
        return text + " " * (2 << 20) if kind == "huge" else text

    def take(self, text):
        """Checks a message of the client and simulates a millisecond with its force."""
        self.n += 1
        try:
            message = json.loads(text, parse_constant=lambda name: self.violation(name + " in a message"))
            if self.n == 1 and message["session"]["configure"]["profile"]["name"] != "phynness":
                self.violation("the first message has another profile: " + text)
            if self.n > 1 and "session" in message:
                self.violation("a later message has a session: " + text)
            (device,) = message["inverse3"]
            if device["device_id"] != self.options.device_id:
                self.violation("another device: " + text)
            named = device["commands"]["set_cursor_force"]
            known = named.get(self.options.force_name)
            if known is None and not self.options.ignores_forces:
                self.violation("a force of another name: " + text)
            force = [float(known[axis]) for axis in "xyz"] if known else [0.0] * 3
        except (ValueError, KeyError, TypeError) as error:
            return self.violation(f"a message is not as documented ({error!r}): {text}")
        size = math.hypot(*force)
        if not size <= self.options.largest_force + 1e-9:
            self.violation(f"a force of {size} N")
        self.pass_silence()
        self.force = force
        self.body.step(force)
        self.log("message {}: force {:.6g} {:.6g} {:.6g}{}".format(
            self.n, *force, " with profile" if "session" in message else ""))
        return None

    def pass_silence(self):
        """The time in which the last force acted without an answer, in real milliseconds."""
        if self.silent_since is None:
            return
        now, before = time.monotonic(), self.body.work_J
        if any(self.force):
            for _ in range(min(10000, round((now - self.silent_since) / STEP_S))):
                self.body.step(self.force)
            self.left_s += now - self.silent_since
            self.left_J += self.body.work_J - before
        self.silent_since = now

    async def answer(self, wire):
        kind = self.answers[self.n - 1] if self.n <= len(self.answers) else self.options.then
        if kind != "ok":
            self.log(f"answer {self.n}: {kind}")
        if kind == "silent" and self.silent_since is None:
            self.silent_since = time.monotonic()
        if kind == "silent" or self.is_closing:
            return True
        if kind == "close":
            await self.close(wire)
            return True
        if kind == "close-half":  # the connection below stays open
            await self.close(wire)
            await wire.receive()
            await asyncio.wait_for(wire.reader.read(), 60)
            return False
        if kind == "vanish":
            wire.writer.transport.abort()
            return False
        if kind == "late":
            self.held_back.append(self.update("ok"))
            return True
        for text in self.held_back:
            await wire.send(1, text.encode())
        self.held_back = []
        if kind == "ping":
            await wire.send(9, b"are you there")
        text = self.update(kind).encode()
        if kind == "fragments":
            await wire.send(1, text[:20], final=False)
            await wire.send(0, text[20:])
        else:
            await wire.send(1, text)
        for _ in range({"twice": 1, "unasked": 5}.get(kind, 0)):
            await wire.send(1, text)
        return True

    async def close(self, wire):
        self.is_closing = True
        await wire.send(8, struct.pack("!H", 1001))

    async def serve(self, reader, writer):
        self.n, self.held_back, self.is_closing = 0, [], False
        try:
            await self.talk(Wire(reader, writer, self))
        except (asyncio.IncompleteReadError, ConnectionError) as error:
            self.log(f"the connection ended without a close frame: {type(error).__name__}")
        self.pass_silence()
        if self.silent_since is not None:
            self.log(f"without answers a force stayed for {self.left_s:.4f} s and did {1e3 * self.left_J:.4f} mJ of work")
        self.log("work on the device {:.9g} J, gross {:.9g} J, last force {:.6g} {:.6g} {:.6g}".format(
            self.body.work_J, self.body.gross_J, *self.force))
        writer.close()
        self.clients_left -= 1
        if self.clients_left == 0:
            self.finished.set()

    async def talk(self, wire):
        if not await wire.upgrade(self.options.greeting == "not-websocket"):
            return
        self.log("connected; greeting: " + self.options.greeting)
        if self.options.greeting == "close":
            await self.close(wire)
        elif self.options.greeting != "silent":
            await wire.send(1, self.greeting().encode())
        while True:
            opcode, data = await wire.receive()
            if opcode == 8:
                self.log("close frame")
                return None if self.is_closing else await wire.send(8, data)
            if opcode == 10:
                self.log("pong: " + data.decode())
            elif opcode == 1:
                self.take(data.decode())
                if not await self.answer(wire):
                    return None
            else:
                self.violation(f"a frame of kind {opcode}")


class Wire:
    """WebSocket frames (RFC 6455) on a stream."""

    def __init__(self, reader, writer, service):
        self.reader, self.writer, self.service = reader, writer, service

    async def upgrade(self, refuse):
        request = (await self.reader.readuntil(b"\r\n\r\n")).decode()
        lines = dict(line.split(": ", 1) for line in request.split("\r\n")[1:] if ": " in line)
        lines = {name.lower(): value for name, value in lines.items()}
        if refuse or lines.get("upgrade", "").lower() != "websocket":
            self.writer.write(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")
            await self.writer.drain()
            return False
        key = base64.b64encode(hashlib.sha1(lines["sec-websocket-key"].encode() + GUID).digest()).decode()
        self.writer.write(("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                           f"Sec-WebSocket-Accept: {key}\r\n\r\n").encode())
        await self.writer.drain()
        return True

    async def send(self, opcode, data, final=True):
        size = len(data)
        length = (bytes([size]) if size < 126 else struct.pack("!BH", 126, size) if size < 1 << 16
                  else struct.pack("!BQ", 127, size))
        self.writer.write(bytes([opcode | (0x80 if final else 0)]) + length + data)
        await self.writer.drain()

    async def receive(self):
        first, second = await self.reader.readexactly(2)
        size = second & 0x7F
        if size >= 126:
            size = int.from_bytes(await self.reader.readexactly(2 if size == 126 else 8), "big")
        if not second & 0x80:
            self.service.violation("a frame of the client is not masked")
            return first & 15, await self.reader.readexactly(size)
        mask = await self.reader.readexactly(4)
        data = await self.reader.readexactly(size)
        return first & 15, bytes(b ^ mask[i % 4] for i, b in enumerate(data))


async def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--log", required=True)
    parser.add_argument("--greeting", choices=GREETINGS, default="ok")
    parser.add_argument("--answers", default="", help="to the first messages, of: " + " ".join(ACTIONS))
    parser.add_argument("--then", choices=ACTIONS, default="ok", help="the answers to later messages")
    parser.add_argument("--device-id", default="049D", help="that the client must name")
    parser.add_argument("--force-name", default="vector", help="that the client must use")
    parser.add_argument("--ignores-forces", action="store_true", help="of other names, as the real one does")
    parser.add_argument("--reports", default="commanded", help="the force in state updates: the commanded one, or newtons along z")
    parser.add_argument("--clients", type=int, default=1, help="number of clients, one after the other")
    parser.add_argument("--largest-force", type=float, default=2.0)
    options = parser.parse_args()
    with open(options.log, "w", encoding="utf-8") as log:
        service = Service(options, log)
        server = await asyncio.start_server(service.serve, "127.0.0.1", 0, limit=1 << 20)
        print("port", server.sockets[0].getsockname()[1], flush=True)
        try:
            await asyncio.wait_for(service.finished.wait(), 120)
        except asyncio.TimeoutError:
            service.log("nobody came, or stayed too long")
            return 4
        finally:
            server.close()
        return 3 if service.violations else 0


sys.exit(asyncio.run(main()))
