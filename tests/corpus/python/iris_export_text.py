# transcribed from sklearn.tree.export_text(clf, feature_names=iris.feature_names)
def predict_species(sepal_length, sepal_width, petal_length, petal_width):
    if petal_width <= 0.80:
        return 'setosa'
    else:
        if petal_width <= 1.75:
            if petal_length <= 4.95:
                if petal_width <= 1.65:
                    return 'versicolor'
                else:
                    return 'virginica'
            else:
                if petal_width <= 1.55:
                    return 'virginica'
                else:
                    if petal_length <= 5.45:
                        return 'versicolor'
                    else:
                        return 'virginica'
        else:
            if petal_length <= 4.85:
                if sepal_width <= 3.10:
                    return 'virginica'
                else:
                    return 'versicolor'
            else:
                return 'virginica'
