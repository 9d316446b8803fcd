"""Calibrates a board over its console: python3 calibrate.py /dev/ttyACM0, or localhost:4000 for TCP."""

import os, socket, sys

def connect(where):
    if not where.startswith("/"):
        host, port = where.rsplit(":", 1)
        return socket.create_connection((host, int(port))).makefile("rwb", buffering=0)
    import termios, tty
    port = os.open(where, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(port)
    modes = termios.tcgetattr(port)
    modes[4] = modes[5] = termios.B115200
    termios.tcsetattr(port, termios.TCSANOW, modes)
    return os.fdopen(port, "r+b", buffering=0)

def line():
    return board.readline().decode("ascii").strip() or sys.exit("the board is gone")

def ask(command):
    board.write(command.encode() + b"\n")
    while not (answer := line()).startswith(("ok", "err")):
        if answer.startswith("+ "):
            print("  ", answer[2:])
    print(command, "->", answer)
    return answer if answer.startswith("ok") else sys.exit(1)

board = connect(sys.argv[1])
ask("cal start")
ask("stream raw")  # turn the board in all directions: 1500 samples are half a minute
print(sum(line().startswith("R,") for _ in range(1500)), "samples")
for command in ("stream off", "cal stop", "cal accept", "cal show"):
    ask(command)
