class DecisionTreeClassifier(object):

    def predict(self, features):
        classes = [0] * 2

        if features[0] <= 6.5:
            if features[2] <= 70.3500022888:
                classes[0] = 112
                classes[1] = 41
            else:
                classes[0] = 23
                classes[1] = 98
        else:
            if features[1] <= 0.5:
                classes[0] = 310
                classes[1] = 12
            else:
                classes[0] = 55
                classes[1] = 56

        index = 0
        for i in range(2):
            if classes[i] > classes[index]:
                index = i
        return index


if __name__ == '__main__':
    import sys
    if len(sys.argv) == 4:
        features = [float(f) for f in sys.argv[1:]]
        print(DecisionTreeClassifier().predict(features))
