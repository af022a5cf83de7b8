# homework 3, task 2: fan control
temp_limit = 25
hum_limit = 60
fan_off = 0
fan_slow = 1
fan_fast = 2

def fan(temperature, humidity):
    result = fan_off
    if temperature > temp_limit:
        result = fan_slow
        if humidity > hum_limit:
            result = fan_fast
    if temperature > temp_limit + 10:
        result = fan_fast
    print("temp", temperature, "fan", result)
    return result

print("testing...")
print(fan(20, 50))
print(fan(30, 70))
