# my robot :)
count = 0

def robot(distance):
    global count
    count = count + 1
    if count % 10 == 0:
        return "look_around"
    if distance < 30:
        return "turn"
    return "go"
