"""PyTorch twins of the image networks, written from their papers under torchvision's names.

torchvision's own classes are not used, so that the scripts need torch alone; `state_dict` names and numbers are
the same. Global pools average whatever size is left.
"""

import torch
from torch import nn


def pooled(x):
    return x.flatten(2).mean(2)


def conv_bn(inputs, outputs, kernel, stride=1, groups=1, activation=nn.ReLU6):
    """Convolution without bias, batch norm, activation: entries 0, 1 and 2."""
    conv = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False)
    return nn.Sequential(conv, nn.BatchNorm2d(outputs), activation())


class InvertedResidual(nn.Module):
    def __init__(self, inputs, outputs, stride, expansion):
        super().__init__()
        wide = inputs * expansion
        layers = [conv_bn(inputs, wide, 1)] if expansion != 1 else []
        layers += [conv_bn(wide, wide, 3, stride, groups=wide), nn.Conv2d(wide, outputs, 1, bias=False), nn.BatchNorm2d(outputs)]
        self.conv = nn.Sequential(*layers)
        self.skip = stride == 1 and inputs == outputs

    def forward(self, x):
        return x + self.conv(x) if self.skip else self.conv(x)


def multiple_of_8(width):
    nearest = max(8, int(width + 4) // 8 * 8)
    return nearest + 8 if nearest < 0.9 * width else nearest


class MobileNetV2(nn.Module):
    """Sandler et al. 2018, Table 2."""

    ROWS = [(1, 16, 1, 1), (6, 24, 2, 2), (6, 32, 3, 2), (6, 64, 4, 2), (6, 96, 3, 1), (6, 160, 3, 2), (6, 320, 1, 1)]

    def __init__(self, classes=6, in_channels=3, width_mult=1.0, dropout=0.2, **_sizes):
        super().__init__()
        channels = multiple_of_8(32 * width_mult)
        layers = [conv_bn(in_channels, channels, 3, 2)]
        for expansion, outputs, repeats, stride in self.ROWS:
            outputs = multiple_of_8(outputs * width_mult)
            for i in range(repeats):
                layers.append(InvertedResidual(channels, outputs, 1 if i else stride, expansion))
                channels = outputs
        last = multiple_of_8(1280 * max(1.0, width_mult))
        self.features = nn.Sequential(*layers, conv_bn(channels, last, 1))
        self.classifier = nn.Sequential(nn.Dropout(dropout), nn.Linear(last, classes))

    def forward(self, x):
        return self.classifier(pooled(self.features(x)))


class Basic(nn.Module):
    """Two convolutions of 3."""

    expansion = 1

    def __init__(self, inputs, width, stride):
        super().__init__()
        self.conv1, self.bn1 = nn.Conv2d(inputs, width, 3, stride, 1, bias=False), nn.BatchNorm2d(width)
        self.conv2, self.bn2 = nn.Conv2d(width, width, 3, 1, 1, bias=False), nn.BatchNorm2d(width)
        self.downsample = downsample(inputs, width, stride)

    def forward(self, x):
        y = self.bn2(self.conv2(torch.relu(self.bn1(self.conv1(x)))))
        return torch.relu(y + self.downsample(x))


def downsample(inputs, outputs, stride):
    if stride == 1 and inputs == outputs:
        return nn.Identity()
    return nn.Sequential(nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs))


class ResNet(nn.Module):
    """He et al. 2016, Table 1."""

    def __init__(self, block, groups, classes, in_channels=3, **_sizes):
        super().__init__()
        self.conv1, self.bn1 = nn.Conv2d(in_channels, 64, 7, 2, 3, bias=False), nn.BatchNorm2d(64)
        channels = 64
        for g, (width, repeats) in enumerate(zip([64, 128, 256, 512], groups)):
            blocks = []
            for i in range(repeats):
                blocks.append(block(channels, width, 2 if g and i == 0 else 1))
                channels = width * block.expansion
            setattr(self, f"layer{g + 1}", nn.Sequential(*blocks))
        self.fc = nn.Linear(channels, classes)

    def forward(self, x):
        x = nn.functional.max_pool2d(torch.relu(self.bn1(self.conv1(x))), 3, 2, 1)
        return self.fc(pooled(self.layer4(self.layer3(self.layer2(self.layer1(x))))))


# The network from its settings, and the settings that are not its own defaults: classes and input.
NETWORKS = {
    "mobilenet-v2": (MobileNetV2, dict(classes=6)),
    "resnet18": (lambda **settings: ResNet(Basic, [2, 2, 2, 2], **settings), dict(classes=3)),
}


def build(name, **settings):
    network, own = NETWORKS[name]
    return network(**{**own, **settings})


def input_shapes(name, **settings):
    sizes = {"in_channels": 3, "height": 224, "width": 224, **NETWORKS[name][1], **settings}
    return [(sizes["in_channels"], sizes["height"], sizes["width"])]
